# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Changes of parameters during a session: ``changes`` of a scenario, read and applied.

::

    changes: "2.0 server.contact_stiffness=3000; 4.0 user1.master.impedance=40 link.delay_s=0.02"

A time [s] from the start of the session, then what is set together. A server takes a change over
with its next step, a master with its next frame, a link with its next packet. What may change is
what may change in a running node. Rates change on the strict channel only, whose packets carry the
time that they stand for, and not where avatars move by the velocity of the step before.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from pmwvc_core.errors import ScenarioError
from pmwvc_core.params import ServerParams
from pmwvc_core.scenario.names import resolved, spec_of, varied
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.server.couplings import Coupling
from pmwvc_core.wave.impedance import MatrixImpedance

CHANGEABLE = ("server", "master", "safety", "link")  # groups
RATE_DROP, PERIOD = "master.rate_drop", "server.period_s"
NEEDS_STRICT = (
    "can change on the strict channel only; on the other channels a packet stands for a fixed time"
)
FIXED = "a black box and its port are fixed once running"
_FORM = "must be 'TIME NAME=VALUE ...; TIME NAME=VALUE ...', such as '2.5 server.object_mass=1'"
_SETTING = re.compile(r"([A-Za-z0-9_.*]+)=(\S+)")


@dataclass(frozen=True)
class Change:
    """Parameters set together: when [s], and values by dotted name."""

    time_s: float
    values: Mapping[str, Any]

    def words(self) -> str:
        """Return what is set, as a scenario has it."""
        return " ".join(f"{name}={value}" for name, value in self.values.items())


def read_changes(text: str) -> list[Change]:
    """Return the changes that a text names, by time; ScenarioError naming what is wrong."""
    found = []
    for each in filter(str.strip, text.split(";")):
        words = each.split()
        settings = [_SETTING.fullmatch(word) for word in words[1:]]
        try:
            time_s = float(words[0])
        except ValueError:
            time_s = -1.0
        if not settings or None in settings or not 0.0 <= time_s < float("inf"):
            raise ScenarioError("changes", [f"{each.strip()!r}: {_FORM}"])
        values = {m[1]: spec_of(m[1]).converted(m[2]) for m in settings if m}
        found.append(Change(time_s, values))
    return sorted(found, key=lambda change: change.time_s)


def changes_text(changes: list[Change]) -> str:
    """Return changes as ``changes`` of a scenario has them."""
    return "; ".join(f"{change.time_s:.9f} {change.words()}" for change in changes)


def over_time(scenario: Scenario) -> list[tuple[Change, Scenario]]:
    """Return each change with the scenario from then on; ScenarioError where not allowed."""
    found, present = [], replace(scenario, changes="")
    for change in read_changes(scenario.changes):
        present = changed(present, change)
        found.append((change, present))
    return found


def changed(scenario: Scenario, change: Change) -> Scenario:
    """Return a scenario with a change, the rest the same objects; else ScenarioError."""
    result = scenario
    strict, server, coupling = scenario.strict, scenario.server, scenario.coupling
    for name, value in change.values.items():
        leaf = resolved(name)[1][0]
        if leaf.split(".")[0] not in CHANGEABLE or spec_of(name).read_only:
            fixed = "is fixed once a session runs"
        elif leaf.startswith("server.") and coupling.black_box:
            fixed = FIXED
        else:
            fixed = why_fixed(leaf, strict=strict, server=server, coupling=coupling)
        if fixed:
            raise ScenarioError("changes", [f"{name}: {fixed}"])
        result = varied(result, name, value)
    if "server.coupling" in change.values and result.coupling.black_box:
        raise ScenarioError("changes", [f"server.coupling = {result.server.coupling}: {FIXED}"])
    users = [_pinned(*pair) for pair in zip(scenario.users, result.users, strict=True)]
    return replace(result, users=tuple(users))


def _pinned(old: User, new: User) -> User:
    """Return a user whose server port keeps its impedance when only the master's changes."""
    own = new.contact
    unchanged = new.master.impedance == old.master.impedance
    if unchanged or own.impedance is not None or own.impedance_matrix.strip():
        return new
    if own is not old.contact or isinstance(old.server_impedance, MatrixImpedance):
        return new
    return replace(new, contact=replace(own, impedance=old.server_impedance))  # type: ignore[arg-type]


def why_fixed(name: str, *, strict: bool, server: ServerParams, coupling: Coupling) -> str:
    """Return why a rate cannot change with this channel, server, coupling; "" if it can."""
    if name in (RATE_DROP, PERIOD) and not strict:
        return NEEDS_STRICT
    if name == PERIOD and (coupling.moves is None or coupling.moves(server)[0] != 0.0):
        return (
            f"is fixed with server.coupling = {coupling.name}, server.integrator = "
            f"{server.integrator}: avatars move by the velocity of the step before"
        )
    return ""
