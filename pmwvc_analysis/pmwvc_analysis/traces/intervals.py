# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Intervals of time [s]: joined, taken out of one another, or not judged."""

from collections.abc import Iterable
from typing import NamedTuple


class Unjudged(NamedTuple):
    """A time in which a balance is unknown, and why."""

    start_s: float
    end_s: float
    why: str


def without(
    intervals: Iterable[tuple[float, float]], start_s: float, end_s: float
) -> list[tuple[float, float]]:
    """Return what is left of a time without some intervals."""
    found, at_s = [], start_s
    for from_s, until_s in [*sorted(intervals), (end_s, end_s)]:
        if from_s > at_s:
            found.append((at_s, min(from_s, end_s)))
        at_s = max(at_s, until_s)
    return found


def merged(intervals: Iterable[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return intervals in the order of time, overlapping ones as one."""
    found: list[tuple[float, float]] = []
    for start_s, end_s in sorted(intervals):
        if found and start_s <= found[-1][1]:
            found[-1] = (found[-1][0], max(found[-1][1], end_s))
        else:
            found.append((start_s, end_s))
    return found
