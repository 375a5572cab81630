# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Figures computed in parallel, one process a core."""

import concurrent.futures
import multiprocessing
import os
from collections.abc import Iterator, Sequence
from pathlib import Path

from reproduction.files import write
from reproduction.registry import FIGURES


def produce(name: str, folder: Path) -> str:
    """Compute and write one figure."""
    figure = FIGURES[name]
    write(figure, figure.result(), folder)
    return name


def produce_all(names: Sequence[str], folder: Path) -> Iterator[str]:
    """Yield the names of figures as they are finished; every process computes with one thread."""
    folder.mkdir(parents=True, exist_ok=True)
    for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ[variable] = "1"
    context = multiprocessing.get_context("spawn")
    with concurrent.futures.ProcessPoolExecutor(os.cpu_count(), mp_context=context) as pool:
        futures = [pool.submit(produce, name, folder) for name in names]
        for future in concurrent.futures.as_completed(futures):
            yield future.result()
