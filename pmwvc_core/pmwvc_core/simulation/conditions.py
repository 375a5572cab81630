# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The conditions of a session in virtual time that its scenario does not name: phases of a frame,
the fate of every packet, the force of a hand, the times at which loops ran.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from pmwvc_core.frame.schedule import AT_ONCE, FrameSchedule
from pmwvc_core.network.recorded_link import RecordedLink
from pmwvc_core.plant.operators import Operator
from pmwvc_core.simulation.event_schedule import Integers, Steps


@dataclass(frozen=True)
class Conditions:
    """Everything but ``schedule`` and ``steps`` is by name of user or link; whatever is not named
    stays simulated.

    Parameters
    ----------
    schedule
        Phases of a frame. With an answer later than the frame start a master takes packets in at
        every tick, and its hand begins the tick after an answer, as live.
    first
        Tick of the session with which a user's first frame starts.
    ran_ns
        When each tick of a user ran; see :class:`.event_schedule.LoopTimes`.
    steps
        When the server stepped.
    links
        Makes the link of one direction, ``user1/up``.
    hands
        Makes the operator of a user.
    """

    schedule: FrameSchedule = AT_ONCE
    first: Mapping[str, int] = field(default_factory=dict)
    ran_ns: Mapping[str, Integers] = field(default_factory=dict)
    steps: Steps | None = None
    links: Mapping[str, Callable[[], RecordedLink]] = field(default_factory=dict)
    hands: Mapping[str, Callable[[], Operator]] = field(default_factory=dict)
