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
from pmwvc_analysis.traces.thresholds import BLOW_N, BREAK_S

FAULTS = {
    fault.number: fault
    for fault in sorted((*SESSIONS, *GROUPS, *PROCESSES), key=lambda fault: fault.number)
}
PAGE = Path(__file__).resolve().parents[2] / "docs" / "faults.md"
HEAD = """# Faults

Injected faults, requirement and result. Two hands carry a cube on the strict channel, 16 ms each
way, for 18 s of virtual time. *Live* rows run real processes on one machine ({machine}); their
numbers vary. `make faults` repeats all and writes this page (about ten minutes);
`PYTHONPATH=tools .venv/bin/python -m faults F05c F22a` repeats some and writes their rows.

* *Step*: largest change of force in 1 ms, without the half second after a contact; allowed:
  {step:g} N, a fifth of the grip.
* *Below half*: time with less than half of the undisturbed force. *Beside the fault*: this and
  time uncoupled, outside outages and stopped nodes; allowed: {gone:g} ms. Zeros are left out.
* *Peak*: largest force over that of the undisturbed session.
* *Offset*: distance of device and avatar in the last second, mean and maximum; allowed:
  F T/(2b) + 1 mm.
* *T*: T1 + T2, port to port and back, as the playouts report it (median of the last second).
  *Fit*: T from the waves' displacement. *Nominal*: T from the mean delays, for the
  bound after a fault that has ended.
* `plain`: the same fault on the plain channel, verdict and largest offset in the last second.

| fault | done | required | result | verdict |
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
    limits = {"step": BLOW_N, "gone": 1e3 * BREAK_S}
    return HEAD.format(machine=machine, **limits) + "\n".join(table) + "\n"


if __name__ == "__main__":
    sys.exit(main())
