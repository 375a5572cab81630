# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The report of a comparison: its files, and its table on the terminal."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from pmwvc_analysis.compare.files import JSON
from pmwvc_analysis.compare.measures import Entry
from pmwvc_analysis.report.comparison_report import COLUMNS, PAGE, write
from pmwvc_bringup.command import Result
from pmwvc_bringup.progress import doing
from pmwvc_core.quantities import cell


def report(
    folder: Path,
    title: str,
    entries: Sequence[Entry],
    console: Console,
    *,
    notes: list[str],
    figures: bool = True,
) -> Result:
    """Write tables and report, print table and notes; the document is ``comparison.json``."""
    about = {"kind": "comparison", "lead": "", "notes": notes}
    with doing("writing the report"):
        found = write(folder, title, entries, about, figures=figures)
    return print_report(folder, [*lines(found), *notes], console, figures=figures)


def print_report(
    folder: Path, texts: Sequence[str], console: Console, *, figures: bool = True
) -> Result:
    """Print lines and where the report is; the document is ``comparison.json``."""
    for line in [*texts, f"report: {folder / (PAGE if figures else JSON)}"]:
        console.print(line, markup=False)
    return Result(document=(folder / JSON).read_text("utf-8"))


def again(folder: Path, console: Console) -> Result:
    """Judge the sessions of a comparison anew and write its report."""
    from pmwvc_analysis.compare.files import read_comparison, read_entries

    before = read_comparison(folder)
    title, notes = str(before["title"]), list(before.get("notes", []))
    with doing("reading the recordings"):
        entries = read_entries(folder)
    return report(folder, title, entries, console, notes=notes)


def lines(found: Mapping[str, Any]) -> list[str]:
    """Return the table of a comparison for a terminal."""
    sessions = found["sessions"]
    width = max(len("session"), *(len(session["label"]) for session in sessions))
    columns = [(name, head, factor) for name, _, head, factor in COLUMNS if head]
    heads = "  ".join(f"{head:>14}" for _, head, _ in columns)
    table = [f"{'session':{width}}  {heads}  verdict"]
    for session in sessions:
        numbers = [
            "-" if session[name] is None else cell(session[name], factor, 4)
            for name, _, factor in columns
        ]
        verdict = "stable" if session["stable"] else session["instability"] or "not judged"
        verdict += {True: "", False: ", not passive"}.get(
            session["passive"], ", passivity not judged"
        )
        cells = "  ".join(f"{number:>14}" for number in numbers)
        table.append(f"{session['label']:{width}}  {cells}  {verdict}")
    table.append(f"{'':{width}}  parameters")
    for session in sessions:
        given = ", ".join(f"{n}={_short(v)}" for n, v in session["parameters"].items())
        tuning = f" ({session['tuning']})" if session["tuning"] else ""
        table.append(f"{session['label']:{width}}  {given or 'none'}{tuning}")
    return [*table, *found["conclusion"]]


def _short(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
