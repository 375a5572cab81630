# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The conditions of a session in virtual time that its scenario does not name: phases of a frame,
the fate of every packet, the force of a hand, the times at which loops ran.
"""

from bisect import bisect_left
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from pmwvc_core.frame import AT_ONCE, FrameSchedule
from pmwvc_core.network.in_flight import RecordedLink
from pmwvc_core.numeric import Array, Integers
from pmwvc_core.plant.hand import Place
from pmwvc_core.plant.hands import Made
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.simulation.links import SimulatedLink
from pmwvc_core.transport.receiver import Receiver


class Ticks:
    """The ticks of a user's loop, counted by the session, of which there are so many."""

    def __init__(self, first: int, ran_ns: Integers | None, ticks: int, tick_ns: int) -> None:
        self.first = first  # tick of the session at which the loop counts 0
        self.next = first  # that runs or passes
        # Time of every tick of the session up to the last that runs.
        self.at_ns: Sequence[int] = range(0, ticks * tick_ns, tick_ns)
        self._missed: frozenset[int] = frozenset()  # in between; they pass when it runs again
        if ran_ns is not None:
            ran = np.flatnonzero(ran_ns[:ticks] >= 0)
            ran = ran[ran >= first]
            every = np.arange(ran[-1] + 1 if len(ran) else 0)
            self.next = int(ran[0]) if len(ran) else 0
            self.at_ns = ran_ns[ran[np.searchsorted(ran, every)]].tolist()
            self._missed = frozenset(np.setdiff1d(every[self.next :], ran).tolist())
        self._ran = self.next - 1  # the last tick that ran

    def are_due(self, until_ns: int) -> bool:
        """Tell whether a tick is due by an instant [ns]."""
        return self.next < len(self.at_ns) and self.at_ns[self.next] <= until_ns

    def passing(self, most: int) -> Iterator[int]:
        """Pass what was missed; yield the ticks before ``most`` after the last one that ran."""
        while self.next in self._missed:
            if self.next < self._ran + most:
                yield self.next
            self.next += 1

    def take(self, before_ns: int, ends: int) -> tuple[range, bool]:
        """Take a frame's ticks before an instant [ns]; return also whether they are its last."""
        begin, ends = self.next, min(ends, len(self.at_ns))
        after = bisect_left(self.at_ns, before_ns, begin, ends)
        if self._missed:
            after = next((k for k in range(begin, after) if k in self._missed), after)
        self._ran, following = after - 1, after
        while following in self._missed:
            following += 1
        self.next = after
        return range(begin, after), following >= ends


class Steps(NamedTuple):
    """The server's steps ``(steps,)``: tick, when it ran [ns], and length [s] of each."""

    tick: Integers
    ran_ns: Integers
    period_s: Array

    def in_order(self) -> Iterator[tuple[int, int, float]]:
        """Return tick, time [ns] and length [s] of each step."""
        return zip(*(column.tolist() for column in self), strict=True)


@dataclass(frozen=True)
class Conditions:
    """Conditions by name of user or link; whatever is not named stays simulated.

    ``schedule`` has the phases of a frame: with an answer later than its start masters take
    packets in at every tick, as live. A user's loop counts 0 at the tick ``first`` of the session;
    ``ran_ns`` is when each of its ticks ran, negative where it did not ``(ticks,)``. ``links``
    makes the link of one direction, ``user1/up``; ``hands`` are state and parameters of the law of
    a user's hand.
    """

    schedule: FrameSchedule = AT_ONCE
    first: Mapping[str, int] = field(default_factory=dict)
    ran_ns: Mapping[str, Integers] = field(default_factory=dict)
    steps: Steps | None = None
    links: Mapping[str, Callable[[], RecordedLink]] = field(default_factory=dict)
    hands: Mapping[str, Made] = field(default_factory=dict)

    def link_of(
        self, scenario: Scenario, index: int, direction: int, inbox: Receiver
    ) -> SimulatedLink:
        """Return a link of the user with a number (from 0): 0 up, 1 down, to a receiver."""
        user = scenario.users[index]
        recorded = self.links.get(f"{user.name}/{('up', 'down')[direction]}")
        return SimulatedLink(
            recorded() if recorded else (user.link_up, user.link_down)[direction],
            seed=(scenario.seed, index, direction),
            inbox=inbox,
            dof=scenario.dof,
            direction=direction,
        )


FROM_SCENARIO = Conditions()


def place_of(user: User, scenario: Scenario) -> Place:
    """Return where a user's hand is: its device starts in front of its face of the object."""
    half_m = scenario.server.object_size_m / 2
    start_m = user.side * (half_m + user.contact.gap_m)
    return Place(user.side, half_m, start_m, scenario.tick_s, scenario.dof)
