# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Ports and parts of an energy budget in words, and what keeps it from closing to rounding.

A *remainder* is the difference that the other parts leave, so that the budget closes with it
whatever it is: a false value there is not found. The accounts that blocks keep
(:class:`pmwvc_core.account.Entry`) are parts as well, with the words that they bring.
"""

from collections.abc import Mapping

import numpy as np

from pmwvc_analysis.traces.holes import Unjudged
from pmwvc_core.controllers.library import entries
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.traces import UserTraces

PARTS: Mapping[str, str] = {  # but for those that are accounts, with words of their own
    "up": "link from the device to the server",
    "down": "link from the server to the device",
    "hand_port": "port of the hand",
    "server": "server with its environment",
    "device_kinetic": "motion of the device",
    "device_damping": "damping of the device",
    "sample_hold": "sampling and holding at the device",
    "safety": "safety limits",
    "filter": "anti-aliasing filter",
    "filter_and_hold": "anti-aliasing filter, hold and filter bank",
    "node_and_link_down": "node and link down with packets in flight",
    "link_up": "link up with packets in flight",
    "link_down": "link down with packets in flight",
    "link": "link in both directions",
    "integration": "integration of the server",
    "contact_damping": "damping of the contacts",
    "contact_stored": "springs of the contacts",
    "environment_stored": "stored by the environment",
    "environment_heat": "dissipated in the environment",
    "object_kinetic": "motion of the object",
    "object_damping": "damping of the object",
}
INFERRED = "the hand's force was not measured; its work is inferred from the motion of the device"
FRICTION = "the heat of friction is exact except where motion reverses"


def accounted(accounts: Mapping[str, Array]) -> dict[str, Array]:
    """Return the accounts that are parts of a budget, as energy taken in."""
    signs = {name: entry.sign for name, entry in entries().items()}
    return {name: signs[name] * sums for name, sums in accounts.items() if signs.get(name)}


def words_of(part: str) -> str:
    """Return a port or part in words."""
    if words := PARTS.get(part):
        return words
    entry = entries().get(part)
    return entry.part or entry.words if entry else part.replace("_", " ")


def of_server(scenario: Scenario) -> set[str]:
    """Return the parts of the server that are remainders."""
    if scenario.coupling.black_box:
        return {"environment_heat"}
    return set() if scenario.coupling.exact else {"integration"}


def notes_on(users: list[UserTraces], known: dict[str, User], ends: Unjudged | None) -> list[str]:
    """Return in words why a budget ends early, and what keeps it from closing to rounding."""
    found = [f"the budget ends at {ends.start_s:.2f} s: {ends.why}"] if ends else []
    for user in users:
        if not np.isfinite(user.f_h).all():
            found.append(f"{user.name}: {INFERRED}")
        if known[user.name].device.friction > 0.0:
            found.append(f"{user.name}: {FRICTION}")
    return found
