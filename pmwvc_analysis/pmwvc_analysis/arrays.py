# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Arrays by name as NPZ, MAT and CSV files."""

import csv
from collections.abc import Mapping, Sequence
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


def write_table(path: Path, columns: Mapping[str, Sequence[Any] | NDArray[Any]]) -> Path:
    """Write what has equal length as columns of a CSV file, in full precision; return it."""
    lists = (np.asarray(column, dtype=object).tolist() for column in columns.values())
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(zip(*lists, strict=True))
    return path
