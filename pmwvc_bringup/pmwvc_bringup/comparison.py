# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The sessions of a comparison: every combination of the values of several parameters, simulated
as one batch; and the report of all of them: its files, and its table on the terminal.
"""

import itertools
import math
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import yaml
from rich.console import Console

from pmwvc_analysis.compare.measures import COLUMNS, Compared, measured
from pmwvc_analysis.report.comparison import JSON, PAGE, write
from pmwvc_bringup import scenarios as files
from pmwvc_bringup.command import Result
from pmwvc_bringup.output import doing
from pmwvc_core.errors import ScenarioError
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.words import cell

CONDITION = "Another task, hand, contact or delay may order these controllers differently."
MOST = 100  # sessions, whose traces are held in memory


class Combination(NamedTuple):
    """One choice of values: its label, the settings and the scenario."""

    label: str
    settings: dict[str, object]
    scenario: Scenario


def combinations(
    name: str, over: Sequence[str], *, settings_texts: Sequence[str] = (), **options: Any
) -> list[Combination]:
    """Return every combination of the values of ``name=a,b,c`` texts, the last varying fastest;
    settings and ``options`` of :func:`.scenarios.load` are of all. ScenarioError with every
    mistake of the scenario, the values and their combinations, each once.
    """
    axes, problems = _axes(over)
    if (count := math.prod(map(len, axes.values()))) > MOST:
        raise ScenarioError(name, [*problems, f"{count} combinations: must be at most {MOST}"])
    last = [path.rpartition(".")[2] for path in axes]
    short = [b if last.count(b) == 1 else path for b, path in zip(last, axes, strict=True)]
    found = []
    for values in itertools.product(*axes.values()):
        texts = [f"{path}={value}" for path, value in zip(axes, values, strict=True)]
        texts = [*settings_texts, *texts]
        try:
            scenario = files.load(name, settings_texts=texts, **options)
        except ScenarioError as error:
            problems += [problem for problem in error.problems if problem not in problems]
            continue
        label = ", ".join(f"{n} = {v}" for n, v in zip(short, values, strict=True))
        settings = dict(zip(axes, map(yaml.safe_load, values), strict=True))
        found.append(Combination(label or scenario.name, settings, scenario))
    if problems:
        raise ScenarioError(name, problems)
    return found


def _axes(over: Sequence[str]) -> tuple[dict[str, list[str]], list[str]]:
    """Return the texts of the values by parameter, and the problems."""
    axes: dict[str, list[str]] = {}
    problems = []
    for text in over:
        path, _, rest = text.partition("=")
        path, values = path.strip(), [value.strip() for value in rest.split(",")]
        if not path or not all(values):
            problems.append(f"--over {text}: must be name=a,b,..., e.g. link.delay_s=0,0.016")
        elif path in axes:
            problems.append(f"--over {path}: is given twice; give all its values once")
        elif len(set(values)) < len(values):
            problems.append(f"--over {text}: a value is given twice")
        else:
            axes[path] = values
    return axes, problems


def simulated(
    chosen: Sequence[Combination], folder: Path, show: Callable[[float], None]
) -> list[Compared]:
    """Simulate all, batched; write each as a session without pictures."""
    from pmwvc_analysis.recording.from_traces import record_traces
    from pmwvc_analysis.session_files import write_summary
    from pmwvc_analysis.verdicts.verdicts import summary
    from pmwvc_core.simulation.session import simulate

    every = [one.scenario for one in chosen]
    traces = simulate(every, progress=lambda part: show(0.5 * part))
    entries = []
    for number, (one, each) in enumerate(zip(chosen, traces, strict=True), start=1):
        plain = re.sub(r"[^A-Za-z0-9_.=-]+", "_", one.label.replace(" = ", "="))[:60]
        below = f"runs/{number:02d}-{plain}"
        record_traces(folder / below, each, one.scenario)
        write_summary(folder / below, summary(each, one.scenario))
        found = Compared(one.label, one.settings, each, one.scenario, below)
        entries.append(measured(found))
        show(0.5 + 0.5 * number / len(chosen))
    return entries


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
    return table
