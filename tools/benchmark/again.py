# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Run one row of ``sessions.csv`` or ``walls.csv`` again, from its text alone, interpreted:
``python -m benchmark.again FILE ROW``. A row that was compiled has the same numbers to rounding.
"""

import argparse
import csv
import dataclasses
import math
import sys
from collections.abc import Mapping
from pathlib import Path

from benchmark.trial import Trial, run
from benchmark.walls import Asked, walls
from benchmark.written import text_of

SAME = 1e-6  # compiled sums are added in another order, and contacts are made of sums


def again(row: Mapping[str, str]) -> dict[str, str]:
    """Return the numbers of a row, computed again, as texts."""
    settings, seed = tuple(row["settings"].split()), int(row["seed"])
    of = row["method"], settings
    found = (
        run(Trial(*of, row["task"], row["network"], seed, float(row["duration_s"])))
        if "task" in row
        else walls(Asked(*of, row["network"], seed))
    )
    return {name: text_of(value) for name, value in dataclasses.asdict(found).items()}


def same(one: str, other: str) -> bool:
    """Tell whether two texts are the same, or two numbers are to rounding."""
    try:
        return one == other or math.isclose(float(one), float(other), rel_tol=SAME, abs_tol=1e-12)
    except ValueError:
        return False


def main() -> int:
    """Print both numbers of each column; return 1 where any differ."""
    parser = argparse.ArgumentParser(prog="python -m benchmark.again")
    parser.add_argument("file", type=Path, help="sessions.csv or walls.csv of a run")
    parser.add_argument("row", type=int, help="number of the row, from 1")
    options = parser.parse_args()
    try:
        rows = list(csv.DictReader(options.file.read_text("utf-8").splitlines()))
    except OSError as error:
        parser.error(f"{options.file}: {error.strerror}")
    if not rows or not {"method", "network", "seed", "settings"} <= set(rows[0]):
        parser.error(f"{options.file}: no rows of a benchmark")
    if not 1 <= options.row <= len(rows):
        parser.error(f"{options.file}: row {options.row}: it has rows 1 to {len(rows)}")
    row = rows[options.row - 1]
    found = again(row)
    print(f"{row['method']} on {row['network']}, seed {row['seed']}")
    for name, value in found.items():
        told = "the same" if same(value, row[name]) else f"other than {row[name]}"
        print(f"{name:18} {value or 'not known'} ({told})")
    return int(any(not same(value, row[name]) for name, value in found.items()))


if __name__ == "__main__":
    sys.exit(main())
