# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Try all faults and write ``docs/faults.md``: ``python -m faults [NUMBER...]``."""

import argparse
import os
import platform
import sys
from itertools import chain
from multiprocessing import Pool
from pathlib import Path

from faults.fault import Fault, Outcome
from faults.groups import GROUPS
from faults.processes import PROCESSES
from faults.sessions import SESSIONS

FAULTS = {
    fault.number: fault
    for fault in sorted((*SESSIONS, *GROUPS, *PROCESSES), key=lambda fault: fault.number)
}
PAGE = Path(__file__).resolve().parents[2] / "docs" / "faults.md"
HEAD = """# Faults

Every fault that is tried, the requirement and the result; `make faults` tries all again and writes
this page (about ten minutes); `PYTHONPATH=tools .venv/bin/python -m faults F05c F22a` tries some
and writes their rows. In virtual time two hands carry a cube on the strict channel, 16 ms each
way, for 18 s; *live* means real processes on one machine, whose numbers differ from run to run
(here: {machine}; starting a process takes seconds there).
A force changes by at most 0.3 N in 1 ms (a blow is more: a fifth of the grip), the half second
after a contact left out; beside what was done a user is uncoupled, or has less than half of its
undisturbed force, for at most 0.1 s, as long as a grip takes to react to a load.
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
    chosen = [f for f in FAULTS.values() if not options.numbers or f.number in options.numbers]
    alone = [fault.number for fault in chosen if fault.live]
    together = [fault.number for fault in chosen if not fault.live]
    tried = []
    with Pool(os.cpu_count()) as pool:
        for number, outcome in chain(pool.imap(attempt, together), map(attempt, alone)):
            fault = FAULTS[number]
            tried.append((fault, outcome))
            print(f"{number:5} {outcome.word:12} {fault.done}: {outcome.seen}", flush=True)
    PAGE.write_text(page({fault.number: row(fault, outcome) for fault, outcome in tried}), "utf-8")
    return int(any(not outcome.held for _, outcome in tried))


def attempt(number: str) -> tuple[str, Outcome]:
    """Try a fault; the others are tried all the same where the attempt itself fails."""
    try:
        return number, FAULTS[number].attempt()
    except Exception as error:
        text = f"the attempt itself failed: {type(error).__name__}: {error}"
        return number, Outcome(False, text)


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
