# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The parts of an energy budget: words, group, and what those hide that are remainders; and the
notes on what keeps a budget from closing to rounding.

A *remainder* is the difference that the other parts leave, so that the budget closes with it
whatever it is: a false value there is not found. *Unchecked* are traces that nothing else on
record confirms. The accounts that blocks keep (:class:`pmwvc_core.account.Entry`) are parts as
well, with the words that they bring.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from pmwvc_analysis.traces.stretches import gaps
from pmwvc_core.account import Role
from pmwvc_core.controllers.library import entries, has_waves, record_of
from pmwvc_core.numeric import Array, Integers
from pmwvc_core.plural import count
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.server.compensations import COMPENSATIONS
from pmwvc_core.traces import ServerTraces, UserTraces


class Part(NamedTuple):
    """A part of a budget."""

    words: str  # empty for those of the account of the same name
    group: str = "controller"  # under which a figure adds it up
    hides: str = ""  # of a remainder: the quantity whose errors no check finds


SKIPPED = "skipped"
PARTS: Mapping[str, Part] = {
    "hand": Part(
        "given by the hand", "hands", "the work of the hand itself: its force was not recorded"
    ),
    "device_kinetic": Part("motion of the device", "devices"),
    "device_damping": Part(
        "damping of the device",
        "devices",
        hides="damping and friction of the device, and errors of its sensors",
    ),
    SKIPPED: Part(
        "while the loop skipped ticks",
        "devices",
        hides="what hand and damping of the device did while the loop skipped ticks",
    ),
    "sample_hold": Part("sampling and holding at the device", "sampling and safety"),
    "safety": Part("safety limits", "sampling and safety"),
    "filter": Part("anti-aliasing filter", "filters and holds"),
    "rate_drop": Part("rate drop", "filters and holds"),
    "hold": Part("hold", "filters and holds"),
    "filter_and_hold": Part(
        "anti-aliasing filter and hold",
        "filters and holds",
        hides="what velocity filter, bank and position feedback accounted for",
    ),
    "node": Part("", "filters and holds"),
    "node_and_link_down": Part("", "filters and holds"),
    "link_up": Part("link up with packets in flight", "links"),
    "link_down": Part("link down with packets in flight", "links"),
    "link": Part("link in both directions", "links", "what the controller accounted for itself"),
    "late_decoding": Part("", "server's computation"),
    "integration": Part(
        "integration of the server",
        "server's computation",
        hides="the energy of the contacts' springs and the heat of their dampers",
    ),
    "withheld": Part("", "server's computation"),
    "contained": Part("", "server's computation"),
    "avatar_brakes": Part("", "contacts"),
    "contact_damping": Part("damping of the contacts", "contacts"),
    "contact_stored": Part("springs of the contacts", "contacts"),
    "environment_stored": Part("stored by the environment", "contacts"),
    "environment_heat": Part(
        "dissipated in the environment",
        "contacts",
        hides="how what the environment took divides into stored and heat",
    ),
    "object_kinetic": Part("motion of the object", "object"),
    "object_damping": Part("damping of the object", "object"),
    "filter_and_rate_drop": Part("anti-aliasing filter and rate drop"),
    "bank": Part(
        "splitting and joining of the filter bank",
        hides="what the local model accounted as stored and dissipated",
    ),
    "environment_stored_and_environment_heat": Part("environment"),
}
INFERRED = "the hand's force was not measured; its work is inferred from the motion of the device"
UNTRUE = "position or velocity is measured, and its device's model does not give the true motion"
FRICTION = "the heat of friction is exact except where motion reverses"
OWN = "what a controller accounts for itself and no signal shows"
LEVEL = "a level that the balance does not use"
SHOWN = "what the environment shows, and no account uses"


def accounted(accounts: Mapping[str, Array]) -> dict[str, Array]:
    """Return the accounts that are parts of a budget, as energy taken in."""
    signs = {name: entry.sign for name, entry in entries().items()}
    return {name: signs[name] * sums for name, sums in accounts.items() if signs.get(name)}


def words_of(part: str) -> str:
    """Return a part in words, or several that are judged together."""
    if words := PARTS.get(part, Part("")).words:
        return words
    if "_and_" in part:
        return ", ".join(words_of(each) for each in part.split("_and_"))
    entry = entries().get(part)
    return entry.part or entry.words if entry else part.replace("_", " ")


def group_of(part: str) -> str:
    """Return the group under which a part is added up."""
    return PARTS.get(part, Part("")).group


def account_words(account: str) -> str:
    """Return a controller's account in words."""
    entry = entries().get(account)
    return entry.words if entry else account.replace("_", " ")


class Remainder(NamedTuple):
    """A part that the budget does not compute for itself."""

    owner: str
    part: str

    @property
    def hides(self) -> str:
        """The quantity whose errors no check finds."""
        return PARTS[self.part].hides


def of_server(scenario: Scenario) -> set[str]:
    """Return the parts of the server that are remainders."""
    if scenario.coupling.black_box:
        return {"environment_heat"}
    return set() if scenario.coupling.exact else {"integration"}


def unchecked(scenario: Scenario) -> dict[str, str]:
    """Return the traces of a session that nothing else on record confirms, and why. Names as in
    :mod:`pmwvc_core.traces`, the server's after ``server.``, an account's after ``accounts.``.
    """
    found, waves = dict[str, str](), has_waves(scenario.controller)
    masters = [user.master for user in scenario.users]
    accounts = [*record_of(scenario.controller).accounts]
    if scenario.coupling.black_box:
        accounts += COMPENSATIONS.of(scenario.server.compensation).accounts
    for entry in accounts:
        if entry.role is not Role.SHOWN:
            why = LEVEL if entry.role is Role.LEVEL else OWN
            found[f"accounts.{entry.name}"] = found[f"server.accounts.{entry.name}"] = why
    if not waves:
        found["f_m"] = "nothing but the limits stands between it and the force applied"
    elif any(m.velocity_filter.is_on or m.bank.is_on for m in masters):
        found["f_m"] = "parts that answer a shortened wave change v_m with it"
    if scenario.strict or (waves and any(m.position.is_on or m.filter.means for m in masters)):
        found["u_m_lp"] = "packets are not its samples"
    if scenario.strict:
        found["energy.v_rx"] = "packets and playout are compared without it"
    if "integration" in of_server(scenario):
        hides = PARTS["integration"].hides
        found["server.potential"] = found["server.dissipated"] = hides
    if scenario.coupling.black_box:
        found |= dict.fromkeys(("server.x_o", "server.xd_o", "server.kinetic"), SHOWN)
    return found


def notes_on(
    users: list[UserTraces],
    known: dict[str, User],
    server: ServerTraces,
    left_over: list[Remainder],
) -> list[str]:
    """Return in words what keeps a budget from closing to rounding."""
    found = []
    for user in users:
        if not np.isfinite(user.f_h).all():
            found.append(f"{user.name}: {INFERRED}")
        found += _started_again(f"{user.name}: its master", user.tick, user.time_s)
        if missing := int(np.sum(np.diff(user.tick)[gaps(user)] - 1)):
            found.append(f"{user.name}: {count(missing, 'tick')} not recorded")
        if Remainder(user.name, "device_damping") in left_over:
            found.append(f"{user.name}: {UNTRUE}")
        if known[user.name].device.friction > 0.0:
            found.append(f"{user.name}: {FRICTION}")
    found += _started_again("server: it", server.step, server.time_s)
    jumps = np.diff(server.step)
    if (jumps > 1).any():
        found.append(f"server: {int(np.sum(jumps[jumps > 1] - 1))} steps were not recorded")
    return found


def _started_again(who: str, numbers: Integers, time_s: Array) -> list[str]:
    rows = np.flatnonzero(np.diff(numbers) < 0) + 1
    again = f"{who} was started again at"
    return [f"{again} {time_s[row]:.2f} s; the budget ends there" for row in rows[:1]]
