# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Run the benchmark and write its table and picture: ``python -m benchmark [full|short]``."""

import argparse
from pathlib import Path

from rich.progress import Progress

from benchmark.study import FULL, SHORT, study
from benchmark.written import TABLE, write


def main() -> None:
    """Run, write, show how far it is."""
    parser = argparse.ArgumentParser(prog="make benchmark")
    parser.add_argument("size", nargs="?", choices=("full", "short"), default="full")
    parser.add_argument("--seed", type=int, default=1, help="of search, hands and packets")
    parser.add_argument("--workers", type=int, help="processes (all cores)")
    parser.add_argument("--dask", metavar="ADDRESS", help="of a Dask scheduler to compute on")
    parser.add_argument("--folder", type=Path, default=Path("sessions/benchmark"))
    options = parser.parse_args()
    plan = SHORT if options.size == "short" else FULL
    with Progress() as progress:
        bar = progress.add_task("sessions", total=plan.sessions)
        found = study(
            plan,
            options.seed,
            workers=options.workers,
            dask=options.dask,
            done=lambda: progress.advance(bar),
        )
    write(found, options.folder)
    print((options.folder / TABLE).read_text("utf-8"))
    print(f"written: {options.folder}")


if __name__ == "__main__":
    main()
