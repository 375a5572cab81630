# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The sessions of a comparison, simulated as one batch or run live one after the other, and the
report of all of them: its files, and its table on the terminal.
"""

import re
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from pmwvc_analysis.compare import settings
from pmwvc_analysis.compare.measures import COLUMNS, Compared, measured
from pmwvc_analysis.report.comparison import JSON, PAGE, write
from pmwvc_bringup.combinations import Combination
from pmwvc_bringup.command import Result
from pmwvc_bringup.output import doing
from pmwvc_bringup.scenarios import to_yaml
from pmwvc_core.errors import PmwvcError
from pmwvc_core.traces import SessionTraces
from pmwvc_core.words import cell

CONDITION = "Another task, hand, contact or delay may order these controllers differently."


def folder_of(number: int, one: Combination) -> str:
    """Return the folder of a session below that of the comparison."""
    plain = re.sub(r"[^A-Za-z0-9_.=-]+", "_", one.label.replace(" = ", "="))[:60]
    return f"runs/{number:02d}-{plain}"


def tuned(chosen: Sequence[Combination], show: Callable[[float], None]) -> list[Combination]:
    """Return the combinations with the baselines of each tuned for its scenario."""
    found: list[Combination] = []
    for one in chosen:
        scenario, words = settings.tuned(
            one.scenario, lambda ratio: show((len(found) + ratio) / len(chosen)), given=one.given
        )
        found.append(one._replace(scenario=scenario, tuning=words))
    return found


def simulated(
    chosen: Sequence[Combination], folder: Path, show: Callable[[float], None]
) -> list[Compared]:
    """Simulate all, batched; write each as a session without pictures."""
    from pmwvc_analysis.recording.from_traces import record_traces
    from pmwvc_analysis.session_files import write_summary
    from pmwvc_analysis.verdicts.verdicts import summary
    from pmwvc_core.simulation.session import simulate

    every = [one.scenario for one in chosen]
    traces = simulate(every, keep=lambda kept, _: kept, progress=lambda part: show(0.5 * part))
    entries = []
    for number, (one, each) in enumerate(zip(chosen, traces, strict=True), start=1):
        below = folder_of(number, one)
        record_traces(folder / below, each, one.scenario)
        write_summary(folder / below, summary(each, one.scenario))
        entries.append(_entry(one, each, below))
        show(0.5 + 0.5 * number / len(chosen))
    return entries


def live(
    chosen: Sequence[Combination], folder: Path, console: Console, *, figures: bool
) -> list[Compared]:
    """Run one session of nodes after the other, each by a runner of its own."""
    from pmwvc_analysis.recording.reader import read_session

    entries = []
    for number, one in enumerate(chosen, start=1):
        below = folder_of(number, one)
        console.print(f"{number} of {len(chosen)}: {one.label}", markup=False)
        with tempfile.TemporaryDirectory() as scratch:
            file = Path(scratch, "scenario.yaml")
            file.write_text(to_yaml(one.scenario), "utf-8")
            words = ["-m", "pmwvc_bringup.cli", "run", str(file), "--out", str(folder / below)]
            words += [] if figures else ["--no-figures"]
            command = [sys.executable, *words]
            code = subprocess.run(command, check=False, stdout=sys.stdout).returncode
        if code == 130:
            raise KeyboardInterrupt
        if code:
            raise PmwvcError(f"{one.label}: the session did not run (exit code {code}); see above")
        entries.append(_entry(one, read_session(folder / below), below))
    return entries


def _entry(one: Combination, traces: SessionTraces, below: str) -> Compared:
    return measured(Compared(one.label, one.settings, traces, one.scenario, below, one.tuning))


def report(
    folder: Path, title: str, entries: Sequence[Compared], console: Console, *, figures: bool
) -> Result:
    """Write tables and report, print the table; the document is ``comparison.json``."""
    about = {"kind": "comparison", "lead": "", "notes": [CONDITION]}
    with doing("writing the report"):
        found = write(folder, title, entries, about, figures=figures)
    return print_report(folder, [*lines(found), CONDITION], console, figures=figures)


def print_report(folder: Path, texts: Sequence[str], console: Console, *, figures: bool) -> Result:
    """Print lines and where the report is; the document is ``comparison.json``."""
    for line in [*texts, f"report: {folder / PAGE}" if figures else f"numbers: {folder / JSON}"]:
        console.print(line, markup=False)
    return Result(document=(folder / JSON).read_text("utf-8"))


def lines(found: Mapping[str, Any]) -> list[str]:
    """Return the table of a comparison for a terminal."""
    sessions = found["sessions"]
    width = max(len("session"), *(len(session["label"]) for session in sessions))
    columns = [(name, head, factor) for name, _, head, factor in COLUMNS if head]
    heads = "  ".join(f"{head:>14}" for _, head, _ in columns)
    table = [f"{'session':{width}}  {heads}  verdict"]
    passivity = {True: "", False: ", not passive", None: ", passivity not judged"}
    for session in sessions:
        values = ((session[name], factor) for name, _, factor in columns)
        numbers = ("-" if value is None else cell(value, factor, 4) for value, factor in values)
        verdict = "stable" if session["stable"] else session["instability"] or "not judged"
        cells = "  ".join(f"{number:>14}" for number in numbers)
        row = f"{session['label']:{width}}  {cells}  {verdict}"
        table.append(row + passivity[session["passive"]])
    table.append(f"{'':{width}}  parameters")
    for session in sessions:
        texts = [
            f"{name}={value:.4g}" if isinstance(value, float) else f"{name}={value}"
            for name, value in session["parameters"].items()
        ]
        tuning = f" ({session['tuning']})" if session["tuning"] else ""
        table.append(f"{session['label']:{width}}  {', '.join(texts) or 'none'}{tuning}")
    return table
