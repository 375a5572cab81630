# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Try all faults and write ``docs/faults.md``: ``python -m faults [NUMBER...]``."""

import argparse
import os
import platform
import sys
from pathlib import Path

from faults.fault import Fault, Outcome
from faults.groups import GROUPS
from faults.processes import PROCESSES
from faults.sessions import SESSIONS

PAGE = Path(__file__).resolve().parents[2] / "docs" / "faults.md"
HEAD = """# Faults

Every fault that is tried, the requirement and the result; `make faults` tries all again and writes
this page (about ten minutes); `PYTHONPATH=tools .venv/bin/python -m faults F05c F22a` tries some
and writes their rows. In virtual time two hands carry a cube on the strict channel, 16 ms each
way, for 18 s; *live* means real processes on one machine, whose numbers differ from run to run
(here: {machine}; starting a process takes seconds there).
"Passive" is judged as in every report; a device may be F (T1 + T2)/(2b) + 1 mm from its avatar.
T1 + T2 is the time that waves take from port to port and back, playouts included: the median of
what the playouts report in the last second. Beside it stands the lag by which the displacements of
the waves at both ends fit each other over the last 3 s. A disturbance that ends must leave no lag
behind: there, as after outages, T is the nominal one, of mean delays and frames.

| fault | done | had to hold | seen | verdict |
|---|---|---|---|---|
"""


def main() -> int:
    """Try, print, write; return 1 where anything did not hold."""
    parser = argparse.ArgumentParser(prog="make faults")
    parser.add_argument("numbers", nargs="*", metavar="NUMBER", help="faults, such as F05c; all")
    options = parser.parse_args()
    faults = sorted((*SESSIONS, *GROUPS, *PROCESSES), key=lambda fault: fault.number)
    chosen = [f for f in faults if not options.numbers or f.number in options.numbers]
    tried = []
    for fault in chosen:
        try:
            outcome = fault.attempt()
        except Exception as error:  # the next fault is tried all the same
            outcome = Outcome(False, f"the attempt itself failed: {type(error).__name__}: {error}")
        tried.append((fault, outcome))
        print(f"{fault.number:5} {outcome.word:12} {fault.done}: {outcome.seen}", flush=True)
    PAGE.write_text(page({fault.number: row(fault, outcome) for fault, outcome in tried}), "utf-8")
    return int(any(not outcome.held for _, outcome in tried))


def row(fault: Fault, outcome: Outcome) -> str:
    """Return a fault's row of the table."""
    done = f"live: {fault.done}" if fault.live else fault.done
    text = f"| {fault.number} | {done} | {fault.wanted} | {outcome.seen} | {outcome.word} |"
    return " ".join(text.split())


def page(rows: dict[str, str]) -> str:
    """Return the text of the page; faults that were not tried now keep their rows."""
    before = PAGE.read_text("utf-8").splitlines() if PAGE.exists() else []
    kept = {line.split("|")[1].strip(): line for line in before if line.startswith("| F")}
    machine = f"{os.cpu_count()} cores, Python {platform.python_version()}, "
    machine += f"load {os.getloadavg()[0]:.0f}"
    table = [text for _, text in sorted((kept | rows).items())]
    return HEAD.format(machine=machine) + "\n".join(table) + "\n"


if __name__ == "__main__":
    sys.exit(main())
