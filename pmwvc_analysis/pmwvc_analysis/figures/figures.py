# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The figures of a session, in reading order. One whose signals were not recorded is left out."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from pmwvc_analysis.charts.chart import Chart
from pmwvc_analysis.charts.chart_files import write
from pmwvc_analysis.figures import recorded
from pmwvc_analysis.figures.link_charts import energy, network
from pmwvc_analysis.figures.motion_charts import forces, positions
from pmwvc_analysis.figures.recorded import conditions, numbered, title
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces

Draw = Callable[[SessionTraces, Scenario | None], Chart | None]
FIGURES: Sequence[Draw] = (positions, forces, energy, network)


def charts(traces: SessionTraces, scenario: Scenario | None) -> list[Chart]:
    """Return every figure that the traces allow."""
    timed = (event for event in numbered(traces.events) if event["time_s"] is not None)
    events = [(event["time_s"], event["number"]) for event in timed]
    note = f"{traces.source}, {traces.duration_s:.1f} s, parameters not known"
    if scenario is not None:
        note = conditions(scenario, traces.source)
    return [
        replace(chart, title=title(chart.heading, scenario), note=note, events=events)
        for draw in FIGURES
        if (chart := draw(traces, scenario)) is not None
    ]


def write_all(drawn: Sequence[Chart], traces: SessionTraces, folder: Path) -> dict[str, Path]:
    """Write figures as ``NAME.png`` and ``NAME.svg``; return the first of these by name."""
    return {chart.name: write(chart, folder, recorded.span(traces))[0] for chart in drawn}
