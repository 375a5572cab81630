# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The report of a session: one self-contained HTML file, verdict first.

All its content is in the summary and the traces; here it is put into words and laid out. Figures
are data from which ``chart.js`` draws them and lets the reader zoom; without it, pictures.
"""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pmwvc_analysis.budget.result import Budget
from pmwvc_analysis.charts.chart import Chart
from pmwvc_analysis.charts.chart_files import payload
from pmwvc_analysis.compare.probes import measured_words
from pmwvc_analysis.figures import recorded
from pmwvc_analysis.figures.recorded import numbered
from pmwvc_analysis.prediction import text as prediction_text
from pmwvc_analysis.report.loop import blocks, drawing
from pmwvc_analysis.report.page import data_uri, filled
from pmwvc_analysis.traces.felt import felt_words
from pmwvc_core.controllers.library import has_waves
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces

TEMPLATE = "report_template.html"
MOST_EVENTS = 60


def render(
    traces: SessionTraces,
    scenario: Scenario | None,
    summary: dict[str, Any],
    charts: Sequence[Chart],
    energies: Budget | None = None,
    *,
    pictures: Mapping[str, Path] | None = None,
    folder: str = "",
    replay: str | None = None,
) -> str:
    """Return the report as HTML; parts that the session does not have are left out.

    ``pictures`` are the figures' PNG files by name, ``folder`` is the session's, for the command
    that plays it on the page, ``replay`` the page's file beside the report.
    """
    events = numbered(summary["events"])
    loops, predicted = [], []
    if scenario is not None:
        waves, model = has_waves(scenario.controller), summary["prediction"]
        for user in scenario.users:
            drawn = drawing(blocks(scenario, user, energies), name=user.name, waves=waves)
            loops.append((user.name, drawn))
        predicted = prediction_text.lines(scenario, live=traces.live)
        if model["mass_felt"] is None and model["stable"] is not False:
            predicted.append(measured_words(scenario))
    chart_data, complete = figure_data(charts, traces, events)
    return filled(
        TEMPLATE,
        title=scenario.name if scenario else "recorded session",
        description=scenario.description if scenario else "",
        folder=folder,
        replay=replay,
        summary=summary,
        loops=loops,
        budget=energies,
        felt=[f"Felt by {each['name']}: {felt_words(each)}." for each in summary["users"]],
        events=events[:MOST_EVENTS],
        more_events=max(0, len(events) - MOST_EVENTS),
        predicted=predicted,
        figures=[(each, pictures and data_uri(pictures[each.name])) for each in charts],
        chart_data=chart_data,
        complete=complete,
        parameters=scenario.flat() if scenario else {},
        software=traces.metadata.get("software", {}),
        scene_options=traces.server.scene.get("options", {}) if traces.server else {},
    )


def figure_data(
    charts: Sequence[Chart], traces: SessionTraces, events: Sequence[Mapping[str, Any]]
) -> tuple[str, bool]:
    """Return the data as JSON that can stand in a page, and whether every point is in it."""
    timed = [(each["time_s"], each) for each in events if each["time_s"] is not None]
    marks = [
        (at_s, each["number"], f"{each['number']}. {at_s:.3f} s: {each['who']} {each['what']}")
        for at_s, each in timed
    ]
    found, complete = payload(charts, recorded.span(traces), marks)
    text = json.dumps(found, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c"), complete
