# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Stability from the exact model: spectral radius, largest stiffness, Z-width.

Stable is a scenario with no eigenvalue outside the unit circle (beyond rounding) once the motions
that are no instability are taken out. The largest stiffness is the first crossing: everything
below it is stable. Where it becomes stable again above, these islands are reported, too.

Equations: docs/theory.md 15.1.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pmwvc_analysis.delays.long_delay import Opened, is_long, opened
from pmwvc_analysis.delays.work import UnknownError, Work
from pmwvc_analysis.models.linearize import Linear, linearize
from pmwvc_analysis.models.motions.groups import subproblems
from pmwvc_analysis.models.variation import with_stiffness
from pmwvc_core.numeric import Array, Flags
from pmwvc_core.scenario.names import varied
from pmwvc_core.scenario.scenario import Scenario

BOUND = 1e6  # [N/m] no contact stiffness above this is looked at
LOWEST = 0.1  # [N/m]
ROUNDING = 1e-9
PER_DECADE = 20
LARGEST_BATCH = 512
ROUGHLY: dict[str, Any] = {"within": 1e-4, "parts": 5}  # where an evaluation is costly
RADIUS = 30  # circles to draw for a radius

Radii = Callable[[Array], Array]  # spectral radius at each of several values


@dataclass(frozen=True)
class Limit:
    """The limit of stability along one parameter.

    ``first`` is the smallest value at which stability is lost: 0 where the lowest value examined
    is unstable already, None where nothing up to ``bound``, the largest one, is.
    """

    first: float | None
    bound: float
    islands: list[tuple[float, float]]  # stable ranges above
    unknown: str = ""  # why it is not known


def radii(scenario: Scenario, *, live: bool = False) -> Array:
    """Return the spectral radii ``(runs,)`` over the hyperperiod, where numbers may be columns;
    UnknownError where that is more work than allowed.
    """
    work = Work(scenario)
    found = [
        (loop.radii(), loop.ticks) for loop in _loops(scenario, work, live=live, circles=RADIUS)
    ]
    ticks = math.lcm(*(length for _, length in found))
    radii_of = [values ** (ticks // length) for values, length in found]
    return np.asarray(np.max(np.broadcast_arrays(*radii_of), axis=0))


def _loops(
    scenario: Scenario, work: Work, *, live: bool, circles: int
) -> Iterator[Linear | Opened]:
    """Yield the models of the smaller problems of a scenario; work is counted before it is done,
    with so many circles for each that is open at long delays.
    """
    for part in subproblems(scenario):
        of: dict[str, Any] = {"live": live, "weights": part.weights}
        work.stepping(part.scenario)
        if is_long(part.scenario, live=live):
            long = opened(part.scenario, **of)
            work.circles(long.loci, circles)
            yield long
        else:
            dense = linearize(part.scenario, **of)
            work.eigenvalues(dense.left)
            yield dense


def _flags(scenario: Scenario, work: Work, *, live: bool) -> Array:
    """Return 0.5 where runs are stable and 2 where not: faster than radii at long delays."""
    found = [
        loop.stable() if isinstance(loop, Opened) else are_stable(loop.radii())
        for loop in _loops(scenario, work, live=live, circles=1)
    ]
    return np.where(np.all(np.broadcast_arrays(*found), axis=0), 0.5, 2.0)


def k_max(scenario: Scenario, *, live: bool = False, bound: float = BOUND) -> Limit:
    """Return the largest contact stiffness [N/m], all contacts in proportion; unknown where it is
    more work than allowed.
    """
    work, smaller = Work(scenario), subproblems(scenario)
    decades = np.log10(bound / LOWEST)
    fine, first = 0.2, list[bool]()
    try:
        if not any(is_long(part.scenario, live=live) for part in smaller):
            states = 1
            for part in smaller:
                work.stepping(part.scenario)
                model = linearize(part.scenario, live=live, weights=part.weights)
                states = max(states, len(model.columns))
            fine = float(np.clip(2e6 / states**3, 0.2, 1.0))  # as eigenvalues take their time
        grid = np.geomspace(LOWEST, bound, 1 + int(np.ceil(decades * PER_DECADE * fine)))

        def at(stiffness: Array) -> Array:
            flags = _flags(with_stiffness(scenario, stiffness), work, live=live)
            first.append(bool(are_stable(flags[0])))
            return flags

        found = crossings(at, grid, **({} if fine == 1.0 else ROUGHLY))
    except UnknownError as error:
        return Limit(None, bound, [], str(error))
    return limit_of(found, stable_at_first=first[0], bound=bound)


def crossings(
    at: Radii, grid: Array, *, within: float = 1e-6, parts: int = 17
) -> list[tuple[float, bool]]:
    """Return where stability changes on a grid, and whether it is regained there.

    Parameters
    ----------
    at
        Spectral radii at a column of values.
    grid
        Ascending values, all positive for a relative precision.
    within
        Relative precision.
    parts
        Into how many an interval is divided at a time.
    """
    flags = are_stable(_batched(at, grid))
    found = []
    for index in np.flatnonzero(flags[1:] != flags[:-1]):
        low, high, begins = float(grid[index]), float(grid[index + 1]), bool(flags[index])
        while high - low > within * max(abs(high), abs(low)):
            inner = np.linspace(low, high, parts + 1)[1:-1]
            same = are_stable(at(inner[:, np.newaxis])) == begins
            step = len(same) if same.all() else int(np.argmin(same))
            ends = [low, *inner.tolist(), high]
            low, high = ends[step], ends[step + 1]
        found.append((0.5 * (low + high), not begins))
    return found


def limit_of(found: list[tuple[float, bool]], *, stable_at_first: bool, bound: float) -> Limit:
    """Return first crossing and islands from the changes found."""
    if not stable_at_first:
        found = [(0.0, False), *found]
    if not found:
        return Limit(None, bound, [])
    ends = [*[value for value, _ in found[1:]], bound]
    islands = [(ends[i], ends[i + 1]) for i in range(0, len(ends) - 1, 2)]
    return Limit(found[0][0], bound, islands)


def z_width(
    scenario: Scenario, damping: Sequence[float], *, live: bool = False, bound: float = BOUND
) -> list[Limit]:
    """Return the largest stiffness for each contact damping [N s/m] that can be rendered."""
    walls = (varied(scenario, "server.contact_damping", b) for b in damping)
    return [k_max(wall, live=live, bound=bound) for wall in walls]


def are_stable(radius: Array) -> Flags:
    """Tell of every spectral radius whether it means stable."""
    return np.asarray(radius <= 1.0 + ROUNDING)


def _batched(at: Radii, grid: Array) -> Array:
    parts = range(0, len(grid), LARGEST_BATCH)
    return np.concatenate([at(grid[i : i + LARGEST_BATCH, np.newaxis]) for i in parts])


def stable(radius: float) -> bool:
    """Tell whether a spectral radius means stable."""
    return bool(radius <= 1.0 + ROUNDING)
