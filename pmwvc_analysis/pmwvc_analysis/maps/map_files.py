# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A stability map on disk: finished points while it grows, then files for people and programs."""

import hashlib
import json
import os
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pmwvc_analysis.arrays import write_arrays, write_table
from pmwvc_analysis.maps.maps import Grid, Points, growth_per_s
from pmwvc_analysis.models.linear import notes_of
from pmwvc_analysis.models.stability import are_stable
from pmwvc_core.errors import PmwvcError
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.names import spec_of

PARTS = "finished.npz"


class Measured(NamedTuple):
    """A session as a point of the map."""

    name: str
    x: float
    y: float
    stable: bool


class Unfinished:
    """The radii of a map that is being computed, NaN where they are not known yet, in a folder
    that is made where need be; PmwvcError where it holds another map.
    """

    def __init__(self, folder: Path, grid: Grid) -> None:
        self._path = folder / PARTS
        self._key = key_of(grid)
        self.radius = np.full(grid.shape, np.nan)
        folder.mkdir(parents=True, exist_ok=True)
        if self._path.exists():
            with np.load(self._path) as stored:
                if str(stored["key"]) != self._key:
                    raise PmwvcError(
                        f"{folder}: holds a map of other parameters; give another --out"
                    )
                self.radius = stored["radius"]

    def known(self) -> int:
        """Return how many points are finished."""
        return int(np.count_nonzero(~np.isnan(self.radius)))

    def add(self, points: Points, values: Array) -> None:
        """Keep some points; what is on disk is whole at any time."""
        self.radius.flat[list(points)] = values
        fresh = self._path.with_name("finished.new.npz")
        np.savez(fresh, radius=self.radius, key=np.array(self._key))
        os.replace(fresh, self._path)


def key_of(grid: Grid) -> str:
    """Return the identity of a map among others."""
    axes = [[axis.name, list(axis.values)] for axis in (grid.x, grid.y)]
    whole = json.dumps([grid.scenario.to_dict(), axes, grid.live], sort_keys=True)
    return hashlib.sha256(whole.encode()).hexdigest()


def first_crossing(values: Array, row: Array) -> float | None:
    """Return where a row loses stability first, between grid points; None where it never does."""
    bad = np.flatnonzero(np.logical_not(are_stable(row)))
    if not len(bad):
        return None
    index = int(bad[0])
    if index == 0:
        return float(values[0])
    low, high = row[index - 1], row[index]
    ratio = (1.0 - low) / (high - low)
    return float(values[index - 1] + ratio * (values[index] - values[index - 1]))


def boundary_of(grid: Grid, radius: Array) -> list[float | None]:
    """Return where each row loses stability first; None where it never does."""
    return [first_crossing(np.array(grid.x.values), row) for row in radius]


def boundary_words(grid: Grid, radius: Array) -> str:
    """Return where the boundary is, by the first and last rows and the extremes."""
    stable = are_stable(radius)
    if stable.all():
        return "stable everywhere on the map"
    if not stable.any():
        return "unstable everywhere on the map"
    limits = boundary_of(grid, radius)
    size = [np.inf if limit is None else limit for limit in limits]
    rows = sorted({0, len(limits) - 1, int(np.argmin(size)), int(np.argmax(size))})
    words = []
    for row in rows:
        limit = limits[row]
        reach = "stable throughout"
        if limit is not None:
            reach = f"stable up to {_given(grid.x.name, limit)}"
        if not stable[row, 0]:
            reach = "unstable from the first value on"
        words.append(f"at {_given(grid.y.name, grid.y.values[row])} {reach}")
    return "boundary: " + "; ".join(words)


def _given(name: str, value: float) -> str:
    unit = spec_of(name).unit
    return f"{name} = {value:.4g}{'' if unit in ('', '-') else f' {unit}'}"


def write_data(folder: Path, grid: Grid, radius: Array, measured: list[Measured]) -> list[Path]:
    """Write NPZ, CSV, MAT and JSON; return the files."""
    x, y = np.array(grid.x.values), np.array(grid.y.values)
    stable, growth = are_stable(radius), growth_per_s(grid, radius)
    arrays = {"spectral_radius": radius, "growth_per_s": growth, "stable": stable}
    names = {"x_name": grid.x.name, "y_name": grid.y.name}
    npz, mat = write_arrays(folder, "map", {"x": x, "y": y, **arrays, **names})
    at_y, at_x = (values.ravel() for values in np.meshgrid(y, x, indexing="ij"))
    columns = [at_x, at_y, radius.ravel(), stable.ravel().astype(int), growth.ravel()]
    heads = [grid.x.name, grid.y.name, "spectral_radius", "stable", "growth_per_s"]
    table = write_table(folder / "map.csv", dict(zip(heads, columns, strict=True)))
    content: dict[str, Any] = {
        "scenario": grid.scenario.name,
        "live": grid.live,
        "x": {"name": grid.x.name, "values": x.tolist()},
        "y": {"name": grid.y.name, "values": y.tolist()},
        **{name: values.tolist() for name, values in arrays.items()},
        "boundary": boundary_of(grid, radius),
        "sessions": [point._asdict() for point in measured],
        "notes": notes_of(grid.scenario),
        "parameters": grid.scenario.to_dict(),
    }
    document = folder / "map.json"
    document.write_text(json.dumps(content, indent=1) + "\n", "utf-8")
    return [npz, table, mat, document]
