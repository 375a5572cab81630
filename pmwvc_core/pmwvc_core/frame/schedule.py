# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The frame schedule: when, after the start of a frame, the server steps and masters take its
answer.
"""

from dataclasses import dataclass

from pmwvc_core.law.user_tick import next_on_grid


@dataclass(frozen=True)
class FrameSchedule:
    """Phases of a frame [s]: the server steps ``server_s`` after its start, on a grid of its own
    period; a master takes the newest answer after ``answer_s``. Zero for both: one instant.
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
