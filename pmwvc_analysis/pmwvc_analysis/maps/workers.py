# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Independent items of work on all cores, or on a Dask cluster, with the same results."""

import concurrent.futures
import contextlib
import importlib
import math
import multiprocessing
import os
import signal
import time
from collections.abc import Callable, Hashable, Iterator, Sequence
from typing import Any, TypeVar

from pmwvc_core.errors import PmwvcError

FIRST = 3  # items from which the duration of the rest is estimated
WORKERS_S = 5.0  # patience until a Dask cluster has a worker
SMALL_S = 4.0  # duration up to which starting other processes does not pay
T = TypeVar("T", bound=Hashable)
R = TypeVar("R")


def finished(
    work: Callable[[T], R], items: Sequence[T], *, workers: int | None, dask: str | None
) -> Iterator[tuple[T, R]]:
    """Yield items with their results as they are finished: by so many processes, by default one
    for each core and none beside this one where there is little to do, or by the cluster of a Dask
    scheduler at an address. Work and items can be pickled. PmwvcError where Dask is not there.
    """
    if workers is None and dask is None:
        took = [math.inf]
        for item in items[:FIRST]:
            began = time.perf_counter()
            result = work(item)
            took.append(time.perf_counter() - began)  # the first also loads what is needed
            yield item, result
        items = items[FIRST:]
        small = not items or min(took) * len(items) < SMALL_S
        workers = 1 if small else (os.cpu_count() or 1)
    if workers == 1 and dask is None:
        yield from ((item, work(item)) for item in items)
        return
    with contextlib.ExitStack() as until:
        if dask is None:
            pool = until.enter_context(_processes(workers))
        else:
            pool = until.enter_context(cluster(dask)).get_executor(pure=False)
        futures = {pool.submit(work, item): item for item in items}
        for future in concurrent.futures.as_completed(futures):
            yield futures[future], future.result()


@contextlib.contextmanager
def _processes(workers: int | None) -> Iterator[concurrent.futures.Executor]:
    """Yield processes; the command line lets each compute with one thread."""
    pool = concurrent.futures.ProcessPoolExecutor(
        workers,
        mp_context=multiprocessing.get_context("spawn"),
        initializer=signal.signal,
        initargs=(signal.SIGINT, signal.SIG_IGN),  # an interruption is this process's to heed
    )
    try:
        yield pool
    finally:
        pool.shutdown(cancel_futures=True)


@contextlib.contextmanager
def cluster(address: str) -> Iterator[Any]:
    """Yield a client of a Dask cluster with at least one worker."""
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
        yield client
