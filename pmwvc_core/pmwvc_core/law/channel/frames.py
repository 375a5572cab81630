# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The frames of a force loop, all in ticks: they begin at the multiples of their length M.

Where M changes, or ticks were skipped, the frame that begins is as long as it takes to the next
multiple, so that both ends keep their phases. A frame whose first ticks were skipped starts, and
takes its answer, with the first tick that runs.
"""

from typing import NamedTuple


class Frames(NamedTuple):
    """The tick with which the next frame starts, that which takes the next answer, and the length
    on whose grid the frame that starts next lies.
    """

    next_frame: int
    next_answer: int
    rate_drop: int


class FrameParams(NamedTuple):
    """Ticks of a frame, M; which of them takes the answer; period of a tick [s]."""

    rate_drop: int
    answer_tick: int
    tick_s: float


def next_on_grid(now: int, every: int, phase: int) -> int:
    """Return the first point of a grid after a time, all in ticks or all in ns."""
    return now + every - (now - phase) % every


def begin_frame(s: Frames, tick: int, p: FrameParams) -> tuple[Frames, float]:
    """Begin a frame with a tick; return how long it lasts [s]."""
    begun = tick - tick % s.rate_drop
    ends = next_on_grid(tick, p.rate_drop, 0)
    return Frames(ends, min(begun + p.answer_tick, ends - 1), p.rate_drop), (
        ends - begun
    ) * p.tick_s


def take_answer(s: Frames, tick: int, p: FrameParams) -> tuple[Frames, bool]:
    """Tell once a frame that the answer is taken with this tick."""
    if tick < s.next_answer:
        return s, False
    return s._replace(next_answer=s.next_answer + p.rate_drop), True
