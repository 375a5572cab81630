# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Stability maps over any two parameters: spectral radii on a grid.

Points whose parameters may differ within a scenario (all numbers but delays and periods) are
computed as one batch. Batches are independent, so they can be computed by several processes, or by
a Dask cluster, with the same result; finished ones can be kept and the rest computed later.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from pmwvc_analysis.maps.workers import finished
from pmwvc_analysis.models.links import hyperperiod_ticks
from pmwvc_analysis.models.stability import LARGEST_BATCH, radii
from pmwvc_analysis.models.variation import stackable
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.names import varied
from pmwvc_core.scenario.scenario import Scenario

Points = tuple[int, ...]  # of a map, counted row by row
Done = Callable[[Points, Array], None]  # points, and their radii
FEWEST_BATCHES = 16  # of a map that could be one: for several processes, and to be kept


@dataclass(frozen=True)
class Axis:
    """A parameter by dotted name, and its values."""

    name: str
    values: tuple[float, ...]


@dataclass(frozen=True)
class Grid:
    """A scenario with two parameters varied: x over the columns of the map, y over its rows."""

    scenario: Scenario
    x: Axis
    y: Axis
    live: bool = False

    @property
    def shape(self) -> tuple[int, int]:
        """Rows (y) and columns (x)."""
        return len(self.y.values), len(self.x.values)

    def batches(self) -> list[Points]:
        """Return the points that are computed together: the same ones at any time."""
        alike = np.arange(np.prod(self.shape)).reshape(self.shape)
        step, along_x = LARGEST_BATCH, stackable(self.x.name)
        if along_x and stackable(self.y.name):
            step = min(step, -(-alike.size // FEWEST_BATCHES))
            alike = alike.reshape(1, -1)
        elif not along_x:
            alike = alike.T if stackable(self.y.name) else alike.reshape(-1, 1)
        width = alike.shape[1]
        return [tuple(row[i : i + step]) for row in alike.tolist() for i in range(0, width, step)]


def batch(grid: Grid, points: Points) -> Array:
    """Return the spectral radii of some points of a map."""
    scenario = grid.scenario
    rows, columns = np.unravel_index(np.array(points), grid.shape)
    for axis, index in ((grid.y, rows), (grid.x, columns)):
        values = np.array(axis.values)[index]
        same = float(values[0])
        several = bool(np.any(values != same))
        scenario = varied(scenario, axis.name, values[:, np.newaxis] if several else same)
    return np.broadcast_to(radii(scenario, live=grid.live), len(points))


def growth_per_s(grid: Grid, radius: Array) -> Array:
    """Return the growth rate ln(radius) per second of every point: radii are per hyperperiod,
    whose length changes along the axis of a period; growth rates compare.
    """

    def hyperperiod_s(y: float, x: float) -> float:
        scenario = varied(varied(grid.scenario, grid.y.name, y), grid.x.name, x)
        return hyperperiod_ticks(scenario) * scenario.tick_s

    x, y = (  # one value stands for all where none changes the hyperperiod
        axis.values[:1] if stackable(axis.name) else axis.values for axis in (grid.x, grid.y)
    )
    seconds = np.array([[hyperperiod_s(b, a) for a in x] for b in y])
    return np.asarray(np.log(np.maximum(radius, np.finfo(float).tiny)) / seconds)


def compute(
    grid: Grid,
    *,
    workers: int | None = None,
    dask: str | None = None,
    known: Array | None = None,
    done: Done | None = None,
) -> Array:
    """Return the spectral radii of a map ``(rows, columns)``; ``workers`` and ``dask`` as for
    :func:`.workers.finished`.

    Parameters
    ----------
    known
        What is known already; NaN is computed.
    done
        Called with points and radii as they are finished.

    Raises
    ------
    PmwvcError
        If a parameter may not have a value of its axis, or Dask is asked for and not there.
    """
    for axis in (grid.x, grid.y):
        for value in axis.values:
            varied(grid.scenario, axis.name, value)  # before any time is spent
    radius = np.full(grid.shape, np.nan) if known is None else known.copy()
    left = [points for points in grid.batches() if np.isnan(radius.flat[list(points)]).any()]
    for points, values in finished(partial(batch, grid), left, workers=workers, dask=dask):
        radius.flat[list(points)] = values
        if done is not None:
            done(points, values)
    return radius
