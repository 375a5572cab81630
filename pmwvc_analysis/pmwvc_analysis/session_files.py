# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The last step of every session, live, simulated or replayed: read, judge, draw, write."""

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from pmwvc_core.errors import file_errors
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces

SUMMARY = "summary.json"
BUDGET = "budget.json"
REPORT = "report.html"
PLOTS = "plots"
REPLAY = "replay.html"
Player = Callable[[SessionTraces, Scenario, Mapping[str, Any]], str | None]


def finish(
    folder: str | Path,
    traces: SessionTraces | None = None,
    scenario: Scenario | None = None,
    *,
    out: str | Path | None = None,
    player: Player | None = None,
    figures: bool = True,
    begins: Callable[[str], None] = lambda part: None,
) -> dict[str, Any]:
    """Write ``summary.json``, ``budget.json``, ``plots/`` and ``report.html``; return the summary.

    Traces and scenario are read from the folder when not given (it may have no scenario). ``out``
    is where to write instead, such as when its disk is full. ``player`` makes the page that plays
    the session, ``replay.html``. Without ``figures`` numbers only are written, the first two
    files. ``begins`` is told each part of the work as it begins. RecordingError where the folder
    holds no recording that can be read, or cannot be written.
    """
    from pmwvc_analysis.budget.budget import budget
    from pmwvc_analysis.figures.figures import charts, write_all
    from pmwvc_analysis.recording.reader import read_scenario, read_session
    from pmwvc_analysis.report.report import render
    from pmwvc_analysis.verdicts.verdicts import summary

    folder = Path(folder)
    begins("reading the recording")
    scenario = scenario or read_scenario(folder)
    traces = traces or read_session(folder)
    begins("judging the session")
    energies = budget(traces, scenario)
    result = summary(traces, scenario, energies)
    traces = replace(traces, events=result["events"])
    target = folder if out is None else Path(out)
    elsewhere = f"'pmwvc report {folder} --out FOLDER' writes the report elsewhere"
    with file_errors(f"write into {target}", f"; what was recorded is kept: {elsewhere}"):
        target.mkdir(parents=True, exist_ok=True)
        write_summary(target, result)
        if energies is not None:
            write_summary(target, energies.summary(), name=BUDGET)
        if not figures:
            return result
        begins("drawing the figures")
        drawn = charts(traces, scenario)
        pictures = write_all(drawn, traces, target / PLOTS)
        begins("writing the report")
        page = player(traces, scenario, result) if player and scenario else None
        if page is not None:
            (target / REPLAY).write_text(page, encoding="utf-8")
        replay = None if page is None else REPLAY
        own = traces, scenario, result, drawn, energies
        report = render(*own, pictures=pictures, folder=str(folder), replay=replay)
        (target / REPORT).write_text(report, encoding="utf-8")
    return result


def write_summary(folder: Path, result: dict[str, Any], *, name: str = SUMMARY) -> None:
    """Write a file of results; a number that is not finite (overflowed signals) is null."""
    text = json.dumps(_finite(result), indent=2, ensure_ascii=False, allow_nan=False)
    (folder / name).write_text(text + "\n", encoding="utf-8")


def _finite(result: Any) -> Any:
    if isinstance(result, dict):
        return {name: _finite(value) for name, value in result.items()}
    if isinstance(result, list | tuple):
        return [_finite(value) for value in result]
    return None if isinstance(result, float) and not math.isfinite(result) else result
