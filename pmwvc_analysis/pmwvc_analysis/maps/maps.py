# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Stability maps over any two parameters: spectral radii on a grid, row by row.

A row is computed as one batch where its parameter may differ within a scenario (all numbers but
delays and periods); where the other one may as well, several rows are. Batches are independent, so
they can be computed by several processes, or by a Dask cluster, with the same result; finished
rows can be kept and the rest computed later.
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
FEWEST_BLOCKS = 16  # of a map with as many rows: for several processes, and to be kept one by one


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
        """Return how many lines make the map: rows, or columns where ``across``."""
        return self.shape[1] if self.across else self.shape[0]

    def blocks(self) -> list[range]:
        """Return the lines that are computed together: the same ones at any time."""
        lines, width = self.lines(), self.shape[0] if self.across else self.shape[1]
        several = stackable(self.x.name) and stackable(self.y.name)
        fitting = min(LARGEST_BATCH // width, lines // FEWEST_BLOCKS) if several else 1
        step = max(fitting, 1)
        return [range(i, min(i + step, lines)) for i in range(0, lines, step)]


def block(grid: Grid, numbers: range) -> Array:
    """Return lines of a map: rows, or columns where ``grid.across``."""
    along, other = (grid.y, grid.x) if grid.across else (grid.x, grid.y)
    batches = stackable(along.name)
    size = LARGEST_BATCH if batches else 1
    at = [other.values[n] for n in numbers]
    radius = np.empty((len(at), len(along.values)))
    pairs = np.array([(a, o) for o in at for a in along.values])
    for first in range(0, len(pairs), size):
        part = pairs[first : first + size]
        scenario = varied(grid.scenario, other.name, part[:, 1:] if len(at) > 1 else at[0])
        scenario = varied(scenario, along.name, part[:, :1] if batches else float(part[0, 0]))
        radius.flat[first : first + size] = radii(scenario, live=grid.live)
    return radius


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
    is_open = np.asarray(np.isnan(table).any(axis=1))
    blocks = [numbers for numbers in grid.blocks() if is_open[numbers].any()]
    for numbers, found in finished(partial(block, grid), blocks, workers=workers, dask=dask):
        for number, values in zip(numbers, found, strict=True):
            if is_open[number]:
                table[number] = values
                if done is not None:
                    done(number, values)
    return radius
