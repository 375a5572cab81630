# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Stability maps over any two parameters: spectral radii on a grid, row by row.

A row is computed as one batch where its parameter may differ within a scenario (all numbers but
delays and periods). Rows are independent, so they can be computed by several processes, or by a
Dask cluster, with the same result; finished rows can be kept and the rest computed later.
"""

import concurrent.futures
import contextlib
import importlib
import math
import multiprocessing
import os
import signal
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from pmwvc_analysis.models.links import hyperperiod_ticks
from pmwvc_analysis.models.stability import LARGEST_BATCH, radii
from pmwvc_analysis.models.variation import stackable
from pmwvc_core.errors import PmwvcError
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.names import varied
from pmwvc_core.scenario.scenario import Scenario

FIRST = 3  # lines from which the duration of the rest is estimated
WORKERS_S = 5.0  # patience until a Dask cluster has a worker
SMALL_MAP_S = 4.0  # duration up to which starting other processes does not pay
BLAS_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
Done = Callable[[int, Array], None]  # number of a row, and the row


@dataclass(frozen=True)
class Axis:
    """A parameter by dotted name, and its values."""

    name: str
    values: tuple[float, ...]


@dataclass(frozen=True)
class Grid:
    """A scenario with two of its parameters varied.

    Attributes
    ----------
    scenario
        All other parameters.
    x, y
        Columns and rows of the map.
    live
        Phases of a live session.
    """

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
    """Return the spectral radii of a map ``(rows, columns)``.

    Parameters
    ----------
    grid
        What to compute.
    workers
        Processes; by default all cores, and none beside this one for a small map.
    dask
        Address of a Dask scheduler to compute on instead.
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
    for number, values in _finished(grid, open_lines, workers=workers, dask=dask):
        table[number] = values
        if done is not None:
            done(number, values)
    return radius


def _finished(
    grid: Grid, numbers: list[int], *, workers: int | None, dask: str | None
) -> Iterator[tuple[int, Array]]:
    """Yield lines as they are finished, wherever they are computed."""
    if dask is not None:
        yield from _on_dask(grid, numbers, dask)
        return
    if workers is None:
        took = [math.inf]
        for number in numbers[:FIRST]:
            began = time.perf_counter()
            values = line(grid, number)
            took.append(time.perf_counter() - began)  # the first also loads what is needed
            yield number, values
        numbers = numbers[FIRST:]
        workers = (
            1
            if len(numbers) == 0 or min(took) * len(numbers) < SMALL_MAP_S
            else (os.cpu_count() or 1)
        )
    if workers == 1:
        for number in numbers:
            yield number, line(grid, number)
        return
    with _one_thread_each():
        context = multiprocessing.get_context("spawn")
        pool = concurrent.futures.ProcessPoolExecutor(
            workers,
            mp_context=context,
            initializer=signal.signal,
            initargs=(signal.SIGINT, signal.SIG_IGN),  # an interruption is this process's to heed
        )
        try:
            futures = {pool.submit(line, grid, number): number for number in numbers}
            for future in concurrent.futures.as_completed(futures):
                yield futures[future], future.result()
        finally:
            pool.shutdown(cancel_futures=True)


@contextlib.contextmanager
def _one_thread_each() -> Iterator[None]:
    """Let the processes started meanwhile compute with one thread each: there is one per core."""
    before = {name: os.environ.get(name) for name in BLAS_THREADS}
    os.environ.update(dict.fromkeys(BLAS_THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def _on_dask(grid: Grid, numbers: Iterable[int], address: str) -> Iterator[tuple[int, Array]]:
    try:
        # Optional with an installed ROS; make setup installs it.
        distributed: Any = importlib.import_module("distributed")
    except ImportError:
        raise PmwvcError(
            "--dask needs the package 'distributed' (pip install distributed), here and on the "
            "cluster together with pmwvc_core and pmwvc_analysis; without it, leave --dask out: "
            "all cores of this machine are used"
        ) from None
    try:
        client: Any = distributed.Client(address, timeout="10s")
    except (OSError, ValueError) as error:
        raise PmwvcError(f"--dask {address}: no scheduler answers there ({error})") from None
    with client:
        try:
            client.wait_for_workers(1, timeout=WORKERS_S)
        except TimeoutError:
            raise PmwvcError(
                f"--dask {address}: the scheduler has no worker; start one with "
                f"'dask worker {address}'"
            ) from None
        futures = {client.submit(line, grid, number, pure=False): number for number in numbers}
        for future, values in distributed.as_completed(list(futures), with_results=True):
            yield futures[future], values
