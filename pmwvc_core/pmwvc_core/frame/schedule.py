# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The frame schedule: when, after the start of a frame, the server steps and masters take its
answer.
"""

from dataclasses import dataclass

from pmwvc_core.law.user_tick import next_on_grid


@dataclass(frozen=True)
class FrameSchedule:
    """Phases of a frame [s]; zero for both makes a frame start, step and answer one instant.

    The server steps ``server_s`` after the start of a frame, on the grid of its own period that is
    shifted by this. A master takes the newest answer ``answer_s`` after the start of a frame,
    which adds to the round trip.
    """

    server_s: float = 0.0
    answer_s: float = 0.0

    def server_tick(self, *, tick_s: float, period_ticks: int) -> int:
        """Return the tick of its period at which the server steps."""
        return round(self.server_s / tick_s) % period_ticks

    def next_step(self, tick: int, *, tick_s: float, period_s: float) -> int:
        """Return the first tick after another one at which the server steps."""
        every = round(period_s / tick_s)
        return next_on_grid(tick, every, self.server_tick(tick_s=tick_s, period_ticks=every))

    def answer_tick(self, *, tick_s: float, rate_drop: int) -> int:
        """Return the tick of a frame that takes the answer, the last one of shorter frames."""
        return min(round(self.answer_s / tick_s), rate_drop - 1)


AT_ONCE = FrameSchedule()  # virtual time
# One machine: the server's step and two ways through the emulator fit between the phases.
LIVE = FrameSchedule(server_s=0.002, answer_s=0.004)
