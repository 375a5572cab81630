# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The segments of a wave that a playout has in store: its integral, and the reserve of energy that
its smoothest wave takes, |dU|^2/(2 dt), where each of them ends.

Times are those of the sender, since the first segment kept began. The list of knots is never
changed: whoever adds or drops one makes another list.
"""

from typing import NamedTuple, TypeAlias

from pmwvc_core.law.vectors import Vector, between, minus, plus, squared

ROUNDING_S = 1e-9  # of times


class Knot(NamedTuple):
    """The end of a segment: when [s], integral [sqrt(W) s] and reserve [J] up to there."""

    end_s: float
    integral: Vector
    reserve_j: float


Knots: TypeAlias = list[Knot]  # the first one is the beginning of the first segment


class Store(NamedTuple):
    """The segments, and how far they are played: integral [sqrt(W) s] and reserve [J]."""

    knots: Knots
    integral: Vector
    reserve_j: float


def added(knots: Knots, integral: Vector, duration_s: float) -> Knots:
    """Return the knots with a segment behind those there are."""
    last = knots[len(knots) - 1]
    reserve_j = last.reserve_j + squared(integral) * (0.5 / duration_s)
    return [*knots, Knot(last.end_s + duration_s, plus(last.integral, integral), reserve_j)]


def played(knots: Knots, time_s: float) -> int:
    """Return how many segments end before a time."""
    count = 0
    while count + 1 < len(knots) and knots[count + 1].end_s <= time_s + ROUNDING_S:
        count += 1
    return count


def forgotten(knots: Knots, count: int) -> Knots:
    """Return the knots without the first segments; the rest begins at zero."""
    e, u, j = knots[count]
    return [Knot(k.end_s - e, minus(k.integral, u), k.reserve_j - j) for k in knots[count:]]


def at(knots: Knots, time_s: float) -> tuple[Vector, float]:
    """Return integral and reserve up to a time, even within a segment."""
    i = 1
    while i < len(knots) - 1 and knots[i].end_s <= time_s:
        i += 1
    before, after = knots[i - 1], knots[i]
    ratio = (time_s - before.end_s) / (after.end_s - before.end_s)
    integral = between(before.integral, after.integral, ratio)
    return integral, before.reserve_j + (after.reserve_j - before.reserve_j) * ratio


def played_to(s: Store, store_s: float) -> Store:
    """Return the store, played up to where so much of it is left [s]."""
    integral, reserve_j = at(s.knots, s.knots[len(s.knots) - 1].end_s - max(store_s, 0.0))
    return Store(s.knots, integral, reserve_j)
