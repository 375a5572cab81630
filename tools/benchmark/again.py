# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Run one row of ``sessions.csv`` or ``probes.csv`` again, from its text alone: ``python -m
benchmark.again FILE ROW``.
"""

import argparse
import csv
import dataclasses
import sys
from collections.abc import Mapping
from pathlib import Path

from benchmark.probe import Probe, rendered
from benchmark.trial import Trial, run
from benchmark.written import text_of


def again(row: Mapping[str, str]) -> dict[str, str]:
    """Return the numbers of a row, computed again, as texts that hold every bit."""
    settings, seed = tuple(row["settings"].split()), int(row["seed"])
    of = row["method"], settings, row["network"], seed
    found = (
        rendered(Probe(*of, hold_s=float(row["hold_s"])))
        if "hold_s" in row
        else run(Trial(*of, duration_s=float(row["duration_s"])))
    )
    return {name: text_of(value) for name, value in dataclasses.asdict(found).items()}


def main() -> int:
    """Print both numbers of each column; return 1 where any differ."""
    parser = argparse.ArgumentParser(prog="python -m benchmark.again")
    parser.add_argument("file", type=Path, help="sessions.csv or probes.csv of a run")
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
        same = "the same" if value == row[name] else f"other than {row[name]}"
        print(f"{name:18} {value or 'not known'} ({same})")
    return int(any(value != row[name] for name, value in found.items()))


if __name__ == "__main__":
    sys.exit(main())
