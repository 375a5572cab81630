# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A stability map on disk: finished lines while it grows, then files for people and programs."""

import csv
import hashlib
import json
import os
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pmwvc_analysis.maps.maps import Grid, growth_per_s
from pmwvc_analysis.models.linear import notes_of
from pmwvc_analysis.models.stability import ROUNDING
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
    """The finished lines of a map that is being computed, in a folder that is made where need be;
    PmwvcError where it holds another map.
    """

    def __init__(self, folder: Path, grid: Grid) -> None:
        self._path = folder / PARTS
        self._key = key_of(grid)
        self._across = grid.across
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
        """Return how many lines are finished."""
        table = self.radius.T if self._across else self.radius
        return int((~np.isnan(table).any(axis=1)).sum())

    def add(self, number: int, values: Array) -> None:
        """Keep a line; what is on disk is whole at any time."""
        table = self.radius.T if self._across else self.radius
        table[number] = values
        fresh = self._path.with_name("finished.new.npz")
        np.savez(fresh, radius=self.radius, key=np.array(self._key))
        os.replace(fresh, self._path)


def key_of(grid: Grid) -> str:
    """Return the identity of a map among others."""
    axes = [[axis.name, list(axis.values)] for axis in (grid.x, grid.y)]
    whole = json.dumps([grid.scenario.to_dict(), axes, grid.live], sort_keys=True)
    return hashlib.sha256(whole.encode()).hexdigest()


def content_of(grid: Grid, radius: Array, measured: list[Measured]) -> dict[str, Any]:
    """Return a map as plain data."""
    return {
        "scenario": grid.scenario.name,
        "live": grid.live,
        "x": {"name": grid.x.name, "values": list(grid.x.values)},
        "y": {"name": grid.y.name, "values": list(grid.y.values)},
        "spectral_radius": radius.tolist(),
        "growth_per_s": growth_per_s(grid, radius).tolist(),
        "stable": (radius <= 1.0 + ROUNDING).tolist(),
        "boundary": [first_crossing(np.array(grid.x.values), row) for row in radius],
        "sessions": [point._asdict() for point in measured],
        "notes": notes_of(grid.scenario, live=grid.live),
        "parameters": grid.scenario.to_dict(),
    }


def first_crossing(values: Array, row: Array) -> float | None:
    """Return where a row loses stability first, between grid points; None where it never does."""
    bad = np.flatnonzero(row > 1.0 + ROUNDING)
    if not len(bad):
        return None
    index = int(bad[0])
    if index == 0:
        return float(values[0])
    low, high = row[index - 1], row[index]
    ratio = (1.0 - low) / (high - low)
    return float(values[index - 1] + ratio * (values[index] - values[index - 1]))


def boundary_words(grid: Grid, radius: Array) -> str:
    """Return where the boundary is, by the first and last rows and the extremes."""
    limits = [first_crossing(np.array(grid.x.values), row) for row in radius]
    if all(limit is None for limit in limits):
        return "stable everywhere on the map"
    if bool((radius > 1.0 + ROUNDING).all()):
        return "unstable everywhere on the map"
    size = [np.inf if limit is None else limit for limit in limits]
    rows = sorted({0, len(limits) - 1, int(np.argmin(size)), int(np.argmax(size))})

    def at(row: int) -> str:
        limit, where = limits[row], f"at {_given(grid.y.name, grid.y.values[row])}"
        if limit is None:
            return f"{where} stable throughout"
        if radius[row, 0] > 1.0 + ROUNDING:
            return f"{where} unstable from the first value on"
        return f"{where} stable up to {_given(grid.x.name, limit)}"

    return "boundary: " + "; ".join(at(row) for row in rows)


def _given(name: str, value: float) -> str:
    unit = spec_of(name).unit
    return f"{name} = {value:.4g}{'' if unit in ('', '-') else f' {unit}'}"


def write_data(folder: Path, grid: Grid, radius: Array, measured: list[Measured]) -> list[Path]:
    """Write NPZ, CSV, MAT and JSON; return the files."""
    from scipy.io import savemat

    x, y = np.array(grid.x.values), np.array(grid.y.values)
    growth = growth_per_s(grid, radius)
    arrays = {
        "x": x,
        "y": y,
        "spectral_radius": radius,
        "growth_per_s": growth,
        "stable": radius <= 1.0 + ROUNDING,
    }
    names = {"x_name": grid.x.name, "y_name": grid.y.name}
    paths = [folder / f"map.{kind}" for kind in ("npz", "csv", "mat", "json")]
    stored: dict[str, Any] = {**arrays, **{k: np.array(text) for k, text in names.items()}}
    np.savez(paths[0], **stored)
    with paths[1].open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow([grid.x.name, grid.y.name, "spectral_radius", "stable", "growth_per_s"])
        for at_y, row, rates in zip(y, radius, growth, strict=True):
            for at_x, value, rate in zip(x, row, rates, strict=True):
                numbers = [repr(float(number)) for number in (at_x, at_y, value)]
                flag = int(value <= 1.0 + ROUNDING)
                writer.writerow([*numbers, flag, repr(float(rate))])
    savemat(paths[2], {**arrays, **names}, do_compression=True)
    text = json.dumps(content_of(grid, radius, measured), indent=1)
    paths[3].write_text(text + "\n", "utf-8")
    return paths
