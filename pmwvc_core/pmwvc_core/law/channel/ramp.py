# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The ramp behind a playout, so that the sender's frames do not come as a staircase into the hand:
the mean of what was asked for in the last N steps.

::

    a_k: what step k asks for,   mean = (a_k + ... + a_{k-N+1})/N,   left <- left + a_k - mean

The displacement is the same, (N - 1)/2 steps later; the energy is no more, up to any step. The
reserve of energy of what was asked goes the same way. Where N changes, what the new ramp does not
hold is due. Equations: docs/theory.md 17.27.
"""

from typing import NamedTuple

from pmwvc_core.law.vectors import Vector, minus, plus, scaled


class Asked(NamedTuple):
    """Integral [sqrt(W) s], and the reserve of what came of it [J]."""

    integral: Vector
    reserve_j: float


class Ramp(NamedTuple):
    """What was asked for in the last N steps, the oldest first; the list is never changed."""

    asked: list[Asked]
    sum: Asked  # of them
    left: Asked  # of them, still to be given out


def _more(s: Asked, a: Asked, less: Asked) -> Asked:
    integral = minus(plus(s.integral, a.integral), less.integral)
    return Asked(integral, s.reserve_j + a.reserve_j - less.reserve_j)


def resting_ramp(rest: Vector, steps: int) -> Ramp:
    """Return a ramp over so many steps to which nothing was asked."""
    nothing = Asked(rest, 0.0)
    return Ramp([nothing for _ in range(steps)], nothing, nothing)


def ramp_step(s: Ramp, asked: Asked) -> tuple[Ramp, Asked]:
    """Return the mean with what a step asks for."""
    steps = len(s.asked)
    if steps == 1:
        return s, asked
    total, part = _more(s.sum, asked, s.asked[0]), 1.0 / steps
    mean = Asked(scaled(total.integral, part), total.reserve_j * part)
    return Ramp([*s.asked[1:], asked], total, _more(s.left, asked, mean)), mean


def changed_ramp(s: Ramp, steps: int) -> tuple[Ramp, Vector]:
    """Go on over so many steps; return the integral that is due now [sqrt(W) s]."""
    before, nothing = s.left.integral, Asked(scaled(s.left.integral, 0.0), 0.0)
    kept, total, left = resting_ramp(nothing.integral, steps).asked, nothing, nothing
    for i in range(min(steps, len(s.asked))):
        kept[steps - 1 - i] = s.asked[len(s.asked) - 1 - i]
    for i in range(steps):
        total = _more(total, kept[i], nothing)
        share = Asked(scaled(kept[i].integral, i / steps), kept[i].reserve_j * (i / steps))
        left = _more(left, share, nothing)
    return Ramp(kept, total, left), minus(before, left.integral)
