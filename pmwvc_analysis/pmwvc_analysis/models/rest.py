# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The playouts of a loop of the exact model, and the ticks in which it comes to rest."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from pmwvc_analysis.models.at_hand import settled_paces
from pmwvc_analysis.models.line import Line
from pmwvc_core.frame.server_step import ServerStep
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.state import State
from pmwvc_core.transport.strict_receiver import StrictReceiver
from pmwvc_core.wave.playout import Playout

STORE_S = 0.1  # more than a settled playout has in store


class Rest(NamedTuple):
    """The beginning of a loop.

    Attributes
    ----------
    start
        Tick with which it begins; tick 0 is a whole number of hyperperiods later.
    settled
        Tick before which the clocks of the playouts are set.
    paces
        To these, by user and way.
    """

    start: int
    settled: int
    paces: Mapping[str, Mapping[str, State]]


def rest_of(scenario: Scenario, lines: Sequence[Line], ticks: int, *, live: bool) -> Rest:
    """Return the beginning of a loop with a hyperperiod of so many ticks: every link has answered
    by tick 0, and what playouts had in store before their clocks were set is played.
    """
    apart = 4 * max(max(line.frame.period, line.serve.period) for line in lines)
    answered, played, paces = max(line.delay for line in lines) + apart, 0, {}
    if scenario.strict:
        played = apart + math.ceil(STORE_S / scenario.tick_s)
        paces = {line.name: settled_paces(line.user, scenario, live=live) for line in lines}
    settled = -ticks * -(-played // ticks)
    start = settled - ticks * (-(-answered // ticks) + 2 * scenario.strict)
    return Rest(start, settled, paces)


def playouts_of(lines: Sequence[Line], step: ServerStep) -> list[tuple[str, Playout]]:
    """Return the playouts of the strict channel by link."""
    ends = [(f"{line.name}.down", line.loop.inbox) for line in lines]
    for line in lines:
        ends += [(f"{line.name}.up", step.inboxes[port]) for port in line.ports]
    return [(name, box.playout) for name, box in ends if isinstance(box, StrictReceiver)]


def set_paces(
    playouts: Sequence[tuple[str, Playout]], paces: Mapping[str, Mapping[str, State]]
) -> None:
    """Set the clocks of the playouts, by user and way."""
    for name, playout in playouts:
        user, _, way = name.rpartition(".")
        playout.add(0.0, 0.0, STORE_S)
        playout.pace.restore(paces[user][way])
