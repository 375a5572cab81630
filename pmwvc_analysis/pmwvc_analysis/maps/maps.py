# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Stability maps over any two parameters: spectral radii on a grid, row by row.

A row is computed as one batch where its parameter may differ within a scenario (all numbers but
delays and periods). Rows are independent, so they can be computed by several processes, or by a
Dask cluster, with the same result; finished rows can be kept and the rest computed later.
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

Done = Callable[[int, Array], None]  # number of a row, and the row


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

    @property
    def across(self) -> bool:
        """True where batches run along y, because only y may differ within a scenario."""
        return stackable(self.y.name) and not stackable(self.x.name)

    def lines(self) -> int:
        """Return how many batches make the map."""
        return self.shape[1] if self.across else self.shape[0]


def line(grid: Grid, number: int) -> Array:
    """Return one line of a map: a row, or a column where ``grid.across``."""
    along, other = (grid.y, grid.x) if grid.across else (grid.x, grid.y)
    scenario = varied(grid.scenario, other.name, other.values[number])
    values = np.array(along.values)
    if not stackable(along.name):
        return np.array(
            [radii(varied(scenario, along.name, v), live=grid.live)[0] for v in along.values]
        )
    parts = [values[i : i + LARGEST_BATCH] for i in range(0, len(values), LARGEST_BATCH)]
    batches = [
        radii(varied(scenario, along.name, part[:, np.newaxis]), live=grid.live) for part in parts
    ]
    widths = [len(part) for part in parts]
    return np.concatenate(
        [np.broadcast_to(b, width) for b, width in zip(batches, widths, strict=True)]
    )


def growth_per_s(grid: Grid, radius: Array) -> Array:
    """Return the growth rate ln(radius) per second of every point: radii are per hyperperiod,
    whose length changes along the axis of a period; growth rates compare.
    """
    seconds = np.empty(grid.shape)
    for row, y in enumerate(_standing(grid.y)):
        for index, x in enumerate(_standing(grid.x)):
            scenario = varied(varied(grid.scenario, grid.y.name, y), grid.x.name, x)
            rows = slice(None) if stackable(grid.y.name) else row
            indices = slice(None) if stackable(grid.x.name) else index
            seconds[rows, indices] = hyperperiod_ticks(scenario) * scenario.tick_s
    found: Array = np.log(np.maximum(radius, np.finfo(float).tiny)) / seconds
    return found


def _standing(axis: Axis) -> tuple[float, ...]:
    """Return the values that may change the hyperperiod: one stands for all where none does."""
    return axis.values[:1] if stackable(axis.name) else axis.values


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
        Called with every line as it is finished.

    Raises
    ------
    PmwvcError
        If a parameter may not have a value of its axis, or Dask is asked for and not there.
    """
    for axis in (grid.x, grid.y):
        for value in axis.values:
            varied(grid.scenario, axis.name, value)  # before any time is spent
    radius = np.full(grid.shape, np.nan) if known is None else known.copy()
    table = radius.T if grid.across else radius
    open_lines = [n for n in range(grid.lines()) if np.isnan(table[n]).any()]
    for number, values in finished(partial(line, grid), open_lines, workers=workers, dask=dask):
        table[number] = values
        if done is not None:
            done(number, values)
    return radius
