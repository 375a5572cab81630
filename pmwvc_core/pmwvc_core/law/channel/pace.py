# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The clock of a playout: how fast it plays the sender's time, and how far beyond what has come;
and the segments that it has in store.

Let e be the end of the newest segment and p the sender's time played. ``store_s`` is e - p: time
in store, or, below zero, -c, the time concealed by a predicted wave. Per step h::

    p <- p + rate ratio h           never beyond e + HOLD_S + FADE_S
    rate  = 1 + shift/T             within 1 +- CORRECTED;   shift <- shift - (rate - 1) ratio h
    ratio = (HOLD_S + FADE_S - c)/FADE_S, within 0..1;   it rises by no more than h/MEND_S

    shift <- shift + a dt/FOLLOW_S  at the first segment, of length dt, of a step with a in store

with T = ``SETTLE_S``/2; no shift within ``SETTLE_S`` after an outage or the start, where all but
one segment is skipped, as is what exceeds ``LONGEST_S`` else. A segment has its integral and the
reserve of energy that its smoothest wave takes, |dU|^2/(2 dt), at most what it brought. The first
knot is at zero. Lists of knots are never changed. Equations: docs/theory.md 17.18.
"""

from typing import NamedTuple

from pmwvc_core.law.channel.constants import FADE_S, HOLD_S, MEND_S, OUTAGE_S, ROUNDING_S, SETTLE_S
from pmwvc_core.law.vectors import Vector, between, minus

FOLLOW_S = 0.4  # the lag follows the mean lateness of packets: some fifty of them
CORRECTED = 0.3  # most by which the playout runs faster or slower: it does not sound in the hand
LONGEST_S = 0.3  # in store: more waves than that are of a time that nobody feels any more


class Pace(NamedTuple):
    """The clock [s]."""

    store_s: float  # time in store; below zero: concealed
    silent_s: float  # without a segment since there was none in store any more
    shift_s: float  # by which the lag is still to become shorter; below zero longer
    ratio: float  # of the sender's time that is played
    burst_s: float  # for which what comes says nothing of lateness
    segment_s: float  # length of the newest segment
    first: bool  # none has come since the last step


NEW = Pace(0.0, 0.0, 0.0, 1.0, SETTLE_S, 0.0, True)  # before any segment


def pace_arrive(s: Pace, lasted_s: float) -> Pace:
    """Note a segment that stands for so long [s]."""
    burst_s, segment_s, shift_s = s.burst_s, s.segment_s, s.shift_s
    if s.silent_s > OUTAGE_S:
        burst_s = SETTLE_S
    else:
        segment_s = lasted_s
    if s.first and burst_s <= 0.0:
        shift_s += s.store_s * min(lasted_s / FOLLOW_S, 1.0)
    return Pace(s.store_s + lasted_s, 0.0, shift_s, s.ratio, burst_s, segment_s, False)


def pace_step(s: Pace, h: float) -> tuple[Pace, float, float]:
    """Go on by h; return also what is skipped before and played beyond what has come [s]."""
    longest_s = s.segment_s if s.burst_s > 0.0 else LONGEST_S
    skipped_s = max(s.store_s - h - longest_s, 0.0)
    store_s = s.store_s - skipped_s
    in_store_s, left_s = max(store_s, 0.0), store_s + HOLD_S + FADE_S
    ratio = max(min(left_s / FADE_S, 1.0, s.ratio + h / MEND_S), 0.0)
    excess = max(min(s.shift_s * (2.0 / SETTLE_S), CORRECTED), -CORRECTED)
    time_s = min((1.0 + excess) * ratio * h, left_s)
    store_s -= time_s
    if abs(store_s) < ROUNDING_S:
        store_s = 0.0
    silent_s, beyond_s = s.silent_s, 0.0
    if store_s < 0.0:
        silent_s += max(h - in_store_s, 0.0)
        beyond_s = max(time_s - in_store_s, 0.0)
    shift_s = s.shift_s - excess * ratio * h
    burst_s = max(s.burst_s - h, 0.0)
    return Pace(store_s, silent_s, shift_s, ratio, burst_s, s.segment_s, True), skipped_s, beyond_s


class Knot(NamedTuple):
    """The end of a segment: when [s], integral [sqrt(W) s] and reserve [J] up to there."""

    end_s: float
    integral: Vector
    reserve_j: float


def dropped(knots: list[Knot], count: int) -> list[Knot]:
    """Return the knots without the first segments; the rest begins at zero."""
    e, u, j = knots[count]
    return [Knot(k.end_s - e, minus(k.integral, u), k.reserve_j - j) for k in knots[count:]]


def played_to(knots: list[Knot], store_s: float) -> tuple[Vector, float]:
    """Return integral and reserve up to where so much is left in store [s], even in a segment."""
    time_s, i = knots[len(knots) - 1].end_s - max(store_s, 0.0), 1
    while i < len(knots) - 1 and knots[i].end_s <= time_s:
        i += 1
    before, after = knots[i - 1], knots[i]
    ratio = (time_s - before.end_s) / (after.end_s - before.end_s)
    integral = between(before.integral, after.integral, ratio)
    return integral, before.reserve_j + (after.reserve_j - before.reserve_j) * ratio
