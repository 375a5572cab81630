# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A position between the counts of an encoder, for one axis.

With e the position measured less the one expected, and q a count::

    x^ <- x^ + xd^ h + a e                     within x +- q

Where the device measures its own velocity, xd^ is that, and e counts beyond half a count only (a =
``OWN``). Where the velocity is the difference of counts, xd^ <- xd^ + B e/h (alpha-beta tracker, a
= ``TRACKED``), at most one count since the last; it grows only with a count and in its direction.

The work is counted over a position z: ``EDGE`` of the way from x^ to the edge crossed last, and x
itself for ``SLOW_S`` after a jump of several counts. The count is the smallest step seen.
Equations: docs/theory.md 17.6, 17.9, 17.21.
"""

from typing import NamedTuple

OWN = 0.3
TRACKED = 0.72  # slower, a device swings about the edge of a count; quicker, its force is noise
BETA = 0.2  # likewise the other way round
EDGE = 0.3  # less, and a swing is counted as work; more, and packets lack energy
SLOW_S = 0.1  # since a jump of several counts: for so long the work is that over x
LEAST_M = 1e-7
UNKNOWN_M = 1.0  # a count before any step was seen
ROUNDING = 1e-6


class Counts(NamedTuple):
    """Of one axis."""

    x: float  # followed [m]
    xd: float  # followed [m/s]
    off: float  # of the position of the work, from the one measured [m]
    edge: float  # between two counts, that was crossed last [m]
    seen: float  # measured last [m]
    still_s: float  # since the last count
    slow_s: float  # since a jump of several counts
    step_m: float  # smallest step seen
    rough: bool  # the velocity is the jump of the counts


def resting_counts(x: float) -> Counts:
    """Return the counts of a device that begins at a position [m]."""
    return Counts(x, 0.0, 0.0, x, x, 0.0, SLOW_S, UNKNOWN_M, False)


def rough_count(s: Counts) -> float:
    """Return the count where the velocity is the jump of the counts; else zero [m]."""
    return s.step_m if s.rough else 0.0


def counts(s: Counts, x: float, xd: float, h: float) -> tuple[Counts, tuple[float, float, float]]:
    """Take what was measured after a tick of h [s]; return the way in it as the wave has it and as
    the force's work counts it [m], and the velocity for the force [m/s].
    """
    before, jump = s.x, x - s.seen
    step = abs(jump)
    count = min(step, s.step_m) if step > 0.0 else s.step_m
    moves = step > 0.0
    still_s = 0.0 if moves else s.still_s + h
    if count < LEAST_M or count >= UNKNOWN_M:
        slow_s = 0.0 if moves else s.slow_s + h
        s = Counts(x, xd, 0.0, x, x, still_s, slow_s, count, False)
        return s, (x - before, jump, xd)
    rough = s.rough
    if moves or abs(xd) > 0.0:
        rough = abs(xd * h - jump) <= ROUNDING * step
    expected = before + (s.xd if rough else xd) * h
    error = x - expected
    if not rough:
        error -= max(min(error, 0.5 * count), -0.5 * count)
    velocity = xd
    if rough:
        fastest = (count + step) / max(still_s, h)
        followed = max(min(s.xd + (BETA / h) * error, fastest), -fastest)
        if not moves:
            velocity = max(min(followed, max(s.xd, 0.0)), min(s.xd, 0.0))
        else:
            velocity = followed if jump * followed > 0.0 else 0.0
    found = expected + (TRACKED if rough else OWN) * error
    found = max(min(found, x + count), x - count)
    edge = max(min(s.edge, x + 0.5 * count), x - 0.5 * count)
    slow_s = 0.0 if step > 1.5 * count else s.slow_s + h
    off = found + EDGE * (edge - found) - x if rough and slow_s >= SLOW_S else 0.0
    after = Counts(found, velocity, off, edge, x, still_s, slow_s, count, rough)
    return after, (found - before, jump + off - s.off, velocity)
