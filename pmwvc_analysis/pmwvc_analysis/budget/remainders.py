# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The parts and traces in which neither energy budget nor consistency checks find an error.

A *remainder* is a part of the budget that is not computed for itself: it is the difference
that the others leave, so that the budget closes with it whatever it is. A false value there is not
found. *Unchecked* are traces that nothing else on record confirms.
"""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from pmwvc_core.account import Role
from pmwvc_core.controllers import has_waves, record_of
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.server.compensations import COMPENSATIONS

# Of each remainder: the quantity whose errors no check finds.
HIDES: Mapping[str, str] = {
    "hand": "the work of the hand itself: its force was not recorded",
    "device_damping": "damping and friction of the device, and errors of its sensors",
    "filter_and_hold": "what velocity filter, bank and position feedback accounted for",
    "bank": "what the local model accounted as stored and dissipated",
    "link": "what the controller accounted for itself",
    "integration": "the energy of the contacts' springs and the heat of their dampers",
    "environment_heat": "how what the environment took divides into stored and heat",
}
OWN = "what a controller accounts for itself and no signal shows"
LEVEL = "a level that the balance does not use"


class Remainder(NamedTuple):
    """A part that the budget does not compute for itself."""

    owner: str
    part: str

    @property
    def hides(self) -> str:
        """The quantity whose errors no check finds."""
        return HIDES[self.part]


def of_server(scenario: Scenario) -> set[str]:
    """Return the parts of the server that are remainders."""
    coupling = scenario.coupling
    if coupling.black_box:
        return {"environment_heat"}
    return set() if coupling.exact else {"integration"}


def unchecked(scenario: Scenario) -> dict[str, str]:
    """Return the traces of a session that nothing else on record confirms, and why.

    Names as in :mod:`pmwvc_core.traces`, those of the server after ``server.``, an
    account after ``accounts.``
    """
    return dict(_unchecked(scenario))


def _unchecked(scenario: Scenario) -> Iterator[tuple[str, str]]:
    waves = has_waves(scenario.controller)
    masters = [user.master for user in scenario.users]
    accounts = [*record_of(scenario.controller).accounts]
    if scenario.coupling.black_box:
        accounts += COMPENSATIONS.of(scenario.server.compensation).accounts
    for entry in accounts:
        if entry.role is not Role.SHOWN:
            why = LEVEL if entry.role is Role.LEVEL else OWN
            yield f"accounts.{entry.name}", why
            yield f"server.accounts.{entry.name}", why
    if not waves:
        yield "f_m", "nothing but the limits stands between it and the force applied"
    elif any(m.velocity_filter.kind != "none" or m.bank.kind != "none" for m in masters):
        yield "f_m", "parts that answer a shortened wave change v_m with it"
    if scenario.strict:
        yield "u_m_lp", "packets are not its samples"
        yield "energy.v_rx", "packets and playout are compared without it"
    kinds = {m.filter.kind for m in masters}
    if waves and (any(m.position.is_on for m in masters) or "integrate_and_dump" in kinds):
        yield "u_m_lp", "packets are not its samples"
    if "integration" in of_server(scenario):
        yield "server.potential", HIDES["integration"]
        yield "server.dissipated", HIDES["integration"]
    if scenario.coupling.black_box:
        for name in ("x_o", "xd_o", "kinetic"):
            yield f"server.{name}", "what the environment shows, and no account uses"
