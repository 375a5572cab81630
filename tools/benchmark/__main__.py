# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Run the benchmark and write its page and picture: ``python -m benchmark [SIZE]``."""

import argparse
import os
import sys
import time
from pathlib import Path

from rich.progress import Progress

from benchmark import estimate, networks, swept
from benchmark.commit import commit
from benchmark.kept import Kept
from benchmark.study import FULL, MEDIUM, SHORT, Plan, study
from benchmark.written import PAGE, write
from pmwvc_core.errors import PmwvcError

PLANS = {"full": FULL, "medium": MEDIUM, "short": SHORT}
SWEEPS = {"networks": networks.FULL, "networks-short": networks.SHORT}


def main() -> int:
    """Say how long it takes, run, write; what an interrupted run finished is not run again."""
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
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # of each process: there is one per core
    plan: Plan | networks.Plan = (PLANS | SWEEPS)[options.size]
    try:
        at_once = estimate.cores(options.workers, options.dask)
        print(f"{options.size}: {estimate.words(plan, at_once)}", flush=True)
        began = time.monotonic()
        page = _run(plan, options)
    except PmwvcError as error:
        print(f"make benchmark: {error}", file=sys.stderr)
        return 2
    print(page.read_text("utf-8"))
    print(f"took {(time.monotonic() - began) / 60.0:.0f} minutes; written: {options.folder}")
    return 0


def _run(plan: Plan | networks.Plan, options: argparse.Namespace) -> Path:
    """Run a plan and return the page written."""
    origin = f"`make benchmark BENCHMARK={options.size}` ({commit()})"
    with Progress() as progress:
        total = plan.items(options.seed) if isinstance(plan, Plan) else plan.items
        bar = progress.add_task("sessions", total=total)
        kept = Kept(
            options.folder,
            workers=options.workers,
            dask=options.dask,
            done=lambda number: progress.advance(bar, number),
        )
        if isinstance(plan, Plan):
            write(study(plan, options.seed, kept), options.folder, origin)
            return Path(options.folder / PAGE)
        groups = list(networks.groups(plan, options.seed))
        path = Path(options.folder / swept.PAGE)
        try:
            kept.results(networks.found_in_each, groups, networks.Found)
        finally:  # also of what an interrupted run finished
            found = kept.finished(groups, networks.Found)
            path.write_text(swept.page(found, origin), "utf-8")
    return path


if __name__ == "__main__":
    sys.exit(main())
