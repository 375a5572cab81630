# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Arrays by name as NPZ, MAT and CSV files."""

import csv
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray


def write_arrays(folder: Path, name: str, arrays: Mapping[str, Any]) -> list[Path]:
    """Write arrays and texts as ``name.npz`` and ``name.mat``; return the files."""
    from scipy.io import savemat

    paths = [folder / f"{name}.npz", folder / f"{name}.mat"]
    np.savez_compressed(paths[0], allow_pickle=False, **arrays)
    savemat(paths[1], dict(arrays), do_compression=True)
    return paths


def write_table(path: Path, columns: Mapping[str, NDArray[Any]]) -> Path:
    """Write arrays of equal length as columns of a CSV file, in full precision; return it."""
    return write_rows(path, columns, zip(*(c.tolist() for c in columns.values()), strict=True))


def write_rows(path: Path, head: Iterable[str], rows: Iterable[Iterable[Any]]) -> Path:
    """Write rows as a CSV file; return it."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(head)
        writer.writerows(rows)
    return path
