# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Conflicts between parameter groups of a scenario that are each valid, and the disturbances of a
live session: ``6 kill server; 7 start server``, a time [s] from its start, an action and the node:
server, netem, recorder, or a user for its master.
"""

import math
import re
from typing import TYPE_CHECKING, NamedTuple

from pmwvc_core.controllers.library import record_of
from pmwvc_core.errors import ParameterError, refusal
from pmwvc_core.network import effects
from pmwvc_core.params.names import timed
from pmwvc_core.params.ports import port_conflicts
from pmwvc_core.server.couplings import COMPENSATIONS, COUPLINGS

ACTIONS = ("kill", "start", "stop", "continue")
SHARED = ("server", "netem", "recorder")
USER = re.compile("user[1-9][0-9]*")


class Disturbance(NamedTuple):
    """One of them."""

    time_s: float
    action: str
    node: str

    def __str__(self) -> str:
        return f"{self.action} {self.node} at {self.time_s:g} s"


def disturbances_of(text: str) -> tuple[Disturbance, ...]:
    """Read the disturbances of a scenario; ParameterError names entry, value and range."""
    found = []
    form = f"TIME ACTION NODE, {' or '.join(ACTIONS)}"
    for where, time_s, words in timed("disturbances", text, form, longest_s=86400.0):
        if len(words) != 2 or words[0] not in ACTIONS:
            raise ParameterError(f"{where}: must be {form}")
        if words[1] not in SHARED and not USER.fullmatch(words[1]):
            raise ParameterError(
                f"{where}: {words[1]!r}: must be {', '.join(SHARED)} or a user, user1"
            )
        found.append(Disturbance(time_s, *words))
    return tuple(found)


if TYPE_CHECKING:
    from pmwvc_core.scenario.scenario import Scenario


def conflicts(scenario: "Scenario") -> list[str]:
    """Return every contradiction in words."""
    named = (
        refusal(record_of, scenario.controller), refusal(COUPLINGS.of, scenario.server.coupling),
        refusal(COMPENSATIONS.of, scenario.server.compensation),
    )  # fmt: skip
    found = [text for text in named if text]
    strict, zeroing = (False, False) if found else (scenario.strict, scenario.zeroing)
    known = (*SHARED, *(user.name for user in scenario.users))
    try:
        unknown = [one for one in disturbances_of(scenario.disturbances) if one.node not in known]
        found += [f"disturbances: {one}: there is no {one.node}" for one in unknown]
    except ParameterError as error:
        found.append(str(error))
    ticks = {user.master.tick_s for user in scenario.users}
    if len(ticks) > 1:
        found.append(f"master.tick_s: {sorted(ticks)}: all users share one tick")
    period, tick = scenario.server.period_s, scenario.tick_s
    ticks_each = round(period / tick)
    if ticks_each < 1 or not math.isclose(period / tick, ticks_each, rel_tol=1e-9):
        found.append(
            f"server.period_s = {period}: must be a whole multiple of master.tick_s = {tick} s "
            f"(it is {period / tick:.6g} ticks)"
        )
    for axis, name in enumerate(("sideways_m", "upwards_m"), 2):
        way_m = getattr(scenario.task, name)
        if way_m and scenario.dof < axis:
            axes = "is one axis" if scenario.dof == 1 else "are two axes"
            found.append(f"task.{name} = {way_m}: there {axes} only; raise dof")
    silence_s = scenario.times.timeout_s
    for user in scenario.users:
        if zeroing and not math.isclose(period, user.master.frame_s):
            found.append(
                f"server.period_s = {period}: must be the packet interval of {user.name} "
                f"({user.master.frame_s:g} s) with channel = zeroing, where a packet counts for "
                "one step"
            )
        position = user.master.position
        if strict and position.is_on and not position.is_paid:
            found.append(
                f"{user.name}.master.position.feedback = printed: generates energy; must be "
                "budgeted or integral with channel = strict, the default; channel = plain has it"
            )
        ports = ("master", user.master, silence_s), ("server", user.contact, user.safety.timeout_s)
        for group, port, waits_s in ports:  # the receiver of each
            wrong = port_conflicts(port, dof=scenario.dof, strict=strict, timeout_s=waits_s)
            found += [f"{user.name}.{group}.{mistake}" for mistake in wrong]
        if user.operator.is_recorded and not user.operator.file:
            found.append(
                f"{user.name}.operator.file is missing: {user.operator.kind} needs a recording"
            )
        for way, link in (("up", user.link_up), ("down", user.link_down)):
            found += [f"{user.name}.link.{way}.{text}" for text in effects.conflicts(link)]
    return found
