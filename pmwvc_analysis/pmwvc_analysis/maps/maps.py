# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Stability maps over any two parameters: spectral radii on a grid, and as files.

Points whose parameters may differ within a scenario (all numbers but delays and periods) are
computed as one batch. Batches are independent, so they can be computed by several processes, or by
a Dask cluster, with the same result.
"""

import json
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from pmwvc_analysis.maps.workers import finished
from pmwvc_analysis.models.linear import notes_of
from pmwvc_analysis.models.linearize import stable
from pmwvc_analysis.models.links import hyperperiod_ticks
from pmwvc_analysis.models.stability import LARGEST_BATCH, radii
from pmwvc_analysis.models.variation import stackable
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.names import varied
from pmwvc_core.scenario.scenario import Scenario

Points = tuple[int, ...]  # of a map, counted row by row
FEWEST_BATCHES = 16  # of a map that could be one: for several processes


@dataclass(frozen=True)
class MapAxis:
    """A parameter by dotted name, and its values."""

    name: str
    values: tuple[float, ...]


@dataclass(frozen=True)
class Grid:
    """A scenario with two parameters varied: x over the columns of the map, y over its rows."""

    scenario: Scenario
    x: MapAxis
    y: MapAxis
    live: bool = False

    @property
    def shape(self) -> tuple[int, int]:
        """Rows (y) and columns (x)."""
        return len(self.y.values), len(self.x.values)

    def batches(self) -> list[Points]:
        """Return the points that are computed together: the same ones at any time."""
        apart = [0 if stackable(axis.name) else 1 for axis in (self.y, self.x)]
        groups: dict[tuple[int, int], list[int]] = defaultdict(list)
        for point in range(self.shape[0] * self.shape[1]):
            row, column = divmod(point, self.shape[1])
            groups[row * apart[0], column * apart[1]].append(point)
        step = LARGEST_BATCH if any(apart) else -(-len(groups[0, 0]) // FEWEST_BATCHES)
        return [
            tuple(points[i : i + step])
            for points in groups.values()
            for i in range(0, len(points), min(step, LARGEST_BATCH))
        ]


def compute(
    grid: Grid,
    *,
    workers: int | None = None,
    dask: str | None = None,
    progress: Callable[[float], None] = lambda ratio: None,
) -> Array:
    """Return the spectral radii of a map ``(rows, columns)``, computed as
    :func:`.workers.finished` says; ``progress`` gets the ratio done, 0..1. PmwvcError for a value
    that a parameter may not have.
    """
    radius, left = np.full(grid.shape, np.nan), grid.batches()
    for points, values in finished(partial(batch, grid), left, workers=workers, dask=dask):
        radius.flat[list(points)] = values
        progress(1.0 - float(np.isnan(radius).mean()))
    return radius


def batch(grid: Grid, points: Points) -> Array:
    """Return the spectral radii of some points of a map."""
    rows, columns = (each.tolist() for each in np.unravel_index(np.array(points), grid.shape))
    along = {row: varied(grid.scenario, grid.y.name, grid.y.values[row]) for row in set(rows)}
    pairs = ((along[row], grid.x.values[i]) for row, i in zip(rows, columns, strict=True))
    return radii(*(varied(of, grid.x.name, value) for of, value in pairs), live=grid.live)


def growth_per_s(grid: Grid, radius: Array) -> Array:
    """Return ln(radius) per second of every point: it compares where radii, which are per
    hyperperiod, do not.
    """
    x, y = (  # one value stands for all where none changes the hyperperiod
        axis.values[:1] if stackable(axis.name) else axis.values for axis in (grid.x, grid.y)
    )
    rows = [varied(grid.scenario, grid.y.name, value) for value in y]
    each = [[varied(row, grid.x.name, value) for value in x] for row in rows]
    seconds = np.array([[hyperperiod_ticks(of) * of.tick_s for of in row] for row in each])
    return np.asarray(np.log(np.maximum(radius, np.finfo(float).tiny)) / seconds)


def write_data(folder: Path, grid: Grid, radius: Array) -> Path:
    """Write ``map.json``; return the file."""
    x, y = grid.x, grid.y
    content: dict[str, Any] = {
        "scenario": grid.scenario.name,
        "live": grid.live,
        "x": {"name": x.name, "values": x.values},
        "y": {"name": y.name, "values": y.values},
        "spectral_radius": radius.tolist(),
        "growth_per_s": growth_per_s(grid, radius).tolist(),
        "stable": stable(radius).tolist(),
        "notes": notes_of(grid.scenario),
        "parameters": grid.scenario.to_dict(),
    }
    document = folder / "map.json"
    document.write_text(json.dumps(content, indent=1) + "\n", "utf-8")
    return document
