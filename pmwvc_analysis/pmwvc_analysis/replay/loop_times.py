# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The times of a recorded force loop: when its ticks ran, its frames began and took answers."""

from dataclasses import dataclass

import numpy as np

from pmwvc_core.simulation.conditions import Integers


@dataclass(frozen=True)
class LoopTimes:
    """The times of one force loop.

    Parameters
    ----------
    first
        Tick of the session with which its first frame starts.
    answer
        Tick of its frame at which it takes the answer.
    ran_ns
        When each tick of the session ran [ns], negative where it did not ``(ticks,)``.
    """

    rate_drop: int
    first: int
    answer: int
    ran_ns: Integers

    def frame_events(self, tick_in_frame: int) -> tuple[Integers, Integers]:
        """Return tick and time [ns] of the first tick of every frame at ``tick_in_frame`` or
        later.

        A loop sends at 0 and takes the answer at ``answer``.
        """
        tick = np.flatnonzero(self.ran_ns >= 0)
        tick = tick[tick >= self.first]
        frame, within = np.divmod(tick - self.first, self.rate_drop)
        may = within >= min(tick_in_frame, self.rate_drop - 1)
        begins = np.diff(frame[may], prepend=-1) > 0  # frames come in their order, from 0
        return tick[may][begins], self.ran_ns[tick[may][begins]]
