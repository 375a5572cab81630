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
    found = [
        (model.radii(), model.ticks)
        for model in _models(scenario, Work(scenario), live=live, circles=RADIUS)
    ]
    ticks = math.lcm(*(length for _, length in found))
    radii_of = [values ** (ticks // length) for values, length in found]
    return np.asarray(np.max(np.broadcast_arrays(*radii_of), axis=0))


def _models(
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


def k_max(scenario: Scenario, *, live: bool = False, bound: float = BOUND) -> Limit:
    """Return the largest contact stiffness [N/m], all contacts in proportion; unknown where it is
    more work than allowed.
    """
    work, smaller = Work(scenario), subproblems(scenario)
    fine = 0.2
    try:
        if not any(is_long(part.scenario, live=live) for part in smaller):
            states = 1
            for part in smaller:
                work.stepping(part.scenario)
                model = linearize(part.scenario, live=live, weights=part.weights)
                states = max(states, len(model.columns))
            fine = float(np.clip(2e6 / states**3, 0.2, 1.0))  # as eigenvalues take their time
        points = 1 + int(np.ceil(np.log10(bound / LOWEST) * PER_DECADE * fine))

        def at(stiffness: Array) -> Array:
            """Return 0.5 where stable and 2 where not: faster than radii at long delays."""
            stiff = with_stiffness(scenario, stiffness)
            found = [
                model.stable() if isinstance(model, Opened) else are_stable(model.radii())
                for model in _models(stiff, work, live=live, circles=1)
            ]
            return np.where(np.all(np.broadcast_arrays(*found), axis=0), 0.5, 2.0)

        grid = np.geomspace(LOWEST, bound, points)
        changes = crossings(at, grid, **({} if fine == 1.0 else ROUGHLY))
    except UnknownError as error:
        return Limit(None, bound, [], str(error))
    values = [*(value for value, _ in changes), bound]
    islands = list(zip(values[1::2], values[2::2], strict=False))
    return Limit(values[0] if changes else None, bound, islands)


def crossings(
    at: Radii, grid: Array, *, within: float = 1e-6, parts: int = 17
) -> list[tuple[float, bool]]:
    """Return where stability changes on a grid, and whether it is regained there; first of all 0
    where the lowest value is unstable.

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
    column, batches = grid[:, np.newaxis], range(0, len(grid), LARGEST_BATCH)
    flags = are_stable(np.concatenate([at(column[i : i + LARGEST_BATCH]) for i in batches]))
    found = [] if flags[0] else [(0.0, False)]
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


def z_width(
    scenario: Scenario, damping: Sequence[float], *, live: bool = False, bound: float = BOUND
) -> list[Limit]:
    """Return the largest stiffness for each contact damping [N s/m] that can be rendered."""
    walls = (varied(scenario, "server.contact_damping", b) for b in damping)
    return [k_max(wall, live=live, bound=bound) for wall in walls]


def are_stable(radius: Array) -> Flags:
    """Tell of every spectral radius whether it means stable."""
    return np.asarray(radius <= 1.0 + ROUNDING)


def stable(radius: float) -> bool:
    """Tell whether a spectral radius means stable."""
    return bool(radius <= 1.0 + ROUNDING)
