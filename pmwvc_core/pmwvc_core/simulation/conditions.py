# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What a session in virtual time takes from elsewhere instead of from its scenario: the phases of
the loops, the fate of every packet, the force of a hand, the times at which loops ran.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from pmwvc_core.network.recorded_link import RecordedLink
from pmwvc_core.plant.operators import Operator
from pmwvc_core.simulation.event_schedule import Integers, Steps


@dataclass(frozen=True)
class Phases:
    """When, after its frame start, what happens [ticks].

    Live loops on one machine have ``Phases(2, 4)``: the server steps 2 ms after the masters have
    sent, and they take its answer at tick 4 (the last one of shorter frames).
    """

    server_ticks: int = 0
    answer_ticks: int = 0


LIVE = Phases(server_ticks=2, answer_ticks=4)


@dataclass(frozen=True)
class Conditions:
    """Everything but ``phases`` is by name of user or link; what is not named stays simulated.

    Parameters
    ----------
    phases
        See :class:`Phases`. With an answer later than the frame start a master takes packets in
        at every tick, and its hand begins the tick after an answer, as live.
    first
        Tick of the session with which a user's first frame starts.
    ran_ns
        When each tick of a user ran; see :class:`pmwvc_core.simulation.event_schedule.Loop`.
    steps
        When the server stepped.
    links
        Makes the link of one direction, ``user1/up``.
    hands
        Makes the operator of a user.
    """

    phases: Phases = Phases()
    first: Mapping[str, int] = field(default_factory=dict)
    ran_ns: Mapping[str, Integers] = field(default_factory=dict)
    steps: Steps | None = None
    links: Mapping[str, Callable[[], RecordedLink]] = field(default_factory=dict)
    hands: Mapping[str, Callable[[], Operator]] = field(default_factory=dict)
