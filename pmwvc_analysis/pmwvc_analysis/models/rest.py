# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The playouts of a loop of the exact model, and the ticks in which it comes to rest."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from pmwvc_analysis.models.at_hand import at_hand
from pmwvc_analysis.models.line import Line
from pmwvc_core.frame.server_step import ServerStep
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.transport.strict_receiver import StrictReceiver
from pmwvc_core.wave.playout import Playout


class Rest(NamedTuple):
    """The beginning of a loop.

    Attributes
    ----------
    start
        Tick with which it begins; tick 0 is a whole number of hyperperiods later.
    filled
        Tick before which the server's playouts get more time at hand.
    more_s
        So much, by user [s].
    """

    start: int
    filled: int
    more_s: Mapping[str, float]


def rest_of(
    scenario: Scenario,
    lines: Sequence[Line],
    ticks: int,
    at_hand_s: Sequence[float],
    *,
    live: bool,
) -> Rest:
    """Return the beginning of a loop with a hyperperiod of so many ticks: every link has answered
    by tick 0, and what playouts have at hand is played. ``at_hand_s`` as of :class:`.loop.Loop`.
    """
    kept_s = at_hand_s or [0.0] * len(lines)
    if scenario.strict and not at_hand_s:
        kept_s = [at_hand(user, scenario, live=live).settled_s for user in scenario.users]
    apart = 4 * max(max(line.frame.period, line.serve.period) for line in lines)
    answered, played = max(line.delay for line in lines) + apart, 0
    if any(kept_s):
        played = apart + math.ceil(max(kept_s) / scenario.tick_s)
    filled = -ticks * -(-played // ticks)
    start = filled - ticks * (-(-answered // ticks) + 2 * scenario.strict)
    return Rest(start, filled, {line.name: s for line, s in zip(lines, kept_s, strict=True)})


def playouts_of(lines: Sequence[Line], step: ServerStep) -> list[tuple[str, Playout]]:
    """Return the playouts of the strict channel by link."""
    ends = [(f"{line.name}.down", line.loop.inbox) for line in lines]
    for line in lines:
        ends += [(f"{line.name}.up", step.inboxes[port]) for port in line.ports]
    return [(name, box.playout) for name, box in ends if isinstance(box, StrictReceiver)]


def fill(playouts: Sequence[tuple[str, Playout]], more_s: Mapping[str, float]) -> None:
    """Give the playouts at the server more time at hand, by user [s]."""
    for name, playout in playouts:
        user, _, way = name.rpartition(".")
        if way == "up" and more_s[user] > 0.0:
            playout.add(0.0, 0.0, more_s[user])
