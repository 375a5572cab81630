# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Independent items of work on all cores, with the same results."""

import concurrent.futures
import contextlib
import math
import multiprocessing
import os
import signal
import time
from collections.abc import Callable, Hashable, Iterator, Sequence
from typing import TypeVar

FIRST = 3  # items from which the duration of the rest is estimated
SMALL_S = 4.0  # duration up to which starting other processes does not pay
BLAS_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
T = TypeVar("T", bound=Hashable)
R = TypeVar("R")


def finished(
    work: Callable[[T], R], items: Sequence[T], *, workers: int | None
) -> Iterator[tuple[T, R]]:
    """Yield items with their results as they are finished: by so many processes, by default one
    for each core and none beside this one where there is little to do. Work and items can be
    pickled.
    """
    if workers is None:
        took = [math.inf]
        for item in items[:FIRST]:
            began = time.perf_counter()
            result = work(item)
            took.append(time.perf_counter() - began)  # the first also loads what is needed
            yield item, result
        items = items[FIRST:]
        small = not items or min(took) * len(items) < SMALL_S
        workers = 1 if small else (os.cpu_count() or 1)
    if workers == 1:
        yield from ((item, work(item)) for item in items)
        return
    with _processes(workers) as pool:
        futures = {pool.submit(work, item): item for item in items}
        for future in concurrent.futures.as_completed(futures):
            yield futures[future], future.result()


@contextlib.contextmanager
def _processes(workers: int) -> Iterator[concurrent.futures.Executor]:
    """Yield processes that compute with one thread each: there is one per core."""
    pool = concurrent.futures.ProcessPoolExecutor(
        workers,
        mp_context=multiprocessing.get_context("spawn"),
        initializer=signal.signal,
        initargs=(signal.SIGINT, signal.SIG_IGN),  # an interruption is this process's to heed
    )
    before = {name: os.environ.pop(name) for name in BLAS_THREADS if name in os.environ}
    os.environ.update(dict.fromkeys(BLAS_THREADS, "1"))
    try:
        yield pool
    finally:
        for name in BLAS_THREADS:
            del os.environ[name]
        os.environ.update(before)
        pool.shutdown(cancel_futures=True)
