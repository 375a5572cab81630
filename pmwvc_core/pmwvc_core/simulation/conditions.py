# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The conditions of a session in virtual time that its scenario does not name: phases of a frame,
the fate of every packet, the force of a hand, the times at which loops ran.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from pmwvc_core.frame.schedule import AT_ONCE, FrameSchedule
from pmwvc_core.network.in_flight import RecordedLink
from pmwvc_core.numeric import Array, Integers
from pmwvc_core.plant.hand import Place
from pmwvc_core.plant.hands import Made
from pmwvc_core.scenario.scenario import Scenario, User


class Steps(NamedTuple):
    """The server's steps: tick of the session of each, when it ran, and how long it lasted [s]
    ``(steps,)``.
    """

    tick: Integers
    ran_ns: Integers
    period_s: Array


@dataclass(frozen=True)
class Conditions:
    """Everything but ``schedule`` and ``steps`` is by name of user or link; whatever is not named
    stays simulated.

    ``schedule`` has the phases of a frame: with an answer later than the frame start a master
    takes packets in at every tick, and its hand begins the tick after an answer, as live. A user's
    loop counts 0 at the tick ``first`` of the session: its frames begin at the multiples of the
    rate drop from there. ``ran_ns`` is when each of its ticks ran, negative where it did not
    ``(ticks,)``. ``steps`` is when the server stepped. ``links`` makes the link of one direction,
    ``user1/up``. ``hands`` are state and parameters of the law of a user's hand.
    """

    schedule: FrameSchedule = AT_ONCE
    first: Mapping[str, int] = field(default_factory=dict)
    ran_ns: Mapping[str, Integers] = field(default_factory=dict)
    steps: Steps | None = None
    links: Mapping[str, Callable[[], RecordedLink]] = field(default_factory=dict)
    hands: Mapping[str, Made] = field(default_factory=dict)


FROM_SCENARIO = Conditions()


def place_of(user: User, scenario: Scenario) -> Place:
    """Return where a user's hand is: its device starts in front of its face of the object."""
    half_m = scenario.server.object_size_m / 2
    start_m = user.side * (half_m + user.contact.gap_m)
    return Place(user.side, half_m, start_m, scenario.tick_s, scenario.dof)
