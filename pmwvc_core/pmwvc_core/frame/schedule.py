# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The frame schedule: when, after the start of a frame, the server steps and masters take its
answer; and the frames of a force loop by that schedule.
"""

from dataclasses import dataclass

from pmwvc_core.state import Stateful


@dataclass(frozen=True)
class FrameSchedule:
    """Phases of a frame [s]; zero for both makes a frame start, step and answer one instant.

    Parameters
    ----------
    server_s
        From the start of a frame to the server's step. Steps lie on the grid of the server's own
        period, shifted by this.
    answer_s
        From the start of a frame to the tick at which a master takes the newest answer. It adds
        to the round trip.
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


def next_on_grid(now: int, every: int, phase: int = 0) -> int:
    """Return the first point of a grid after a time, all in ticks or all in ns.

    Frames and steps lie at the multiples of their own length, so that both ends keep their phases;
    where a length changes, the frame or step that begins then is as long as it takes to the next
    point of the new grid.
    """
    return now + every - (now - phase) % every


class Frames(Stateful):
    """The frames of a force loop, which begin at the multiples of their length; all in ticks.

    A frame whose first ticks were skipped starts and takes its answer at the first tick that runs.

    Parameters
    ----------
    schedule
        Phases of a frame.
    rate_drop
        Ticks of a frame at the start.
    tick_s
        Period of a tick [s].

    Attributes
    ----------
    rate_drop, answer_tick
        Length of a frame, and which of its ticks takes the answer.
    next_frame
        Tick with which the next frame starts.
    next_event
        Tick with which that is due, or the answer before it.
    """

    MEMORY = "next_frame next_event _next_answer"

    def __init__(self, schedule: FrameSchedule, *, rate_drop: int, tick_s: float) -> None:
        self._schedule, self._tick_s = schedule, tick_s
        self.configure(rate_drop)
        self.next_frame = self.next_event = self._next_answer = 0

    def configure(self, rate_drop: int) -> None:
        """Take another length over, with the next frame."""
        self.rate_drop = rate_drop
        self.answer_tick = self._schedule.answer_tick(tick_s=self._tick_s, rate_drop=rate_drop)

    def starts(self, tick: int) -> bool:
        """Tell whether a tick is the first of its frame to run."""
        return tick >= self.next_frame

    def start(self, tick: int, begun: int) -> float:
        """Start the frame that began with tick ``begun``; return how long it lasts [s]."""
        self.next_frame = next_on_grid(tick, self.rate_drop)
        self._next_answer = min(begun + self.answer_tick, self.next_frame - 1)
        self.next_event = self._next_answer
        return (self.next_frame - begun) * self._tick_s

    def take_answer(self, tick: int) -> bool:
        """Tell once a frame that the answer is due."""
        if tick < self._next_answer:
            return False
        self._next_answer += self.rate_drop  # until the frame starts that sets it
        self.next_event = self.next_frame
        return True


AT_ONCE = FrameSchedule()  # virtual time
# One machine: the server's step and two ways through the emulator fit between the phases.
LIVE = FrameSchedule(server_s=0.002, answer_s=0.004)
