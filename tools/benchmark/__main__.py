# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Run the benchmark and write its tables and picture: ``python -m benchmark [SIZE]``."""

import argparse
from pathlib import Path

from rich.progress import Progress

from benchmark import networks
from benchmark.kept import Kept
from benchmark.study import FULL, MEDIUM, SHORT, Plan, study
from benchmark.written import TABLE, write

PLANS = {"full": FULL, "medium": MEDIUM, "short": SHORT}
SWEEPS = {"networks": networks.FULL, "networks-short": networks.SHORT}


def main() -> None:
    """Run, write, show how far it is; what an interrupted run finished is not run again."""
    parser = argparse.ArgumentParser(prog="make benchmark")
    parser.add_argument(
        "size",
        nargs="?",
        choices=(*PLANS, *SWEEPS),
        default="full",
        help="networks: energy of the channels of waves on every network, for a minute each",
    )
    parser.add_argument("--seed", type=int, default=1, help="of search, hands and packets")
    parser.add_argument("--workers", type=int, help="processes (all cores)")
    parser.add_argument("--dask", metavar="ADDRESS", help="of a Dask scheduler to compute on")
    parser.add_argument("--folder", type=Path, default=Path("sessions/benchmark"))
    options = parser.parse_args()
    plan: Plan | networks.Plan = (PLANS | SWEEPS)[options.size]
    with Progress() as progress:
        bar = progress.add_task("sessions", total=plan.items)
        kept = Kept(
            options.folder,
            workers=options.workers,
            dask=options.dask,
            done=lambda: progress.advance(bar),
        )
        if isinstance(plan, Plan):
            write(study(plan, options.seed, kept), options.folder)
            table = options.folder / TABLE
        else:
            table = options.folder / networks.TABLE
            table.write_text(networks.table(networks.sweep(plan, options.seed, kept)), "utf-8")
    print(table.read_text("utf-8"))
    print(f"written: {options.folder}")


if __name__ == "__main__":
    main()
