# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The report of a session: one self-contained HTML file, verdict first.

All its content is in the summary and the traces; here it is put into words and laid out. Figures
are markup that shows them without a script, and the data with which ``chart.js`` lets the reader
zoom.
"""

import json
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from pmwvc_analysis.budget.result import Budget
from pmwvc_analysis.charts import chart_svg
from pmwvc_analysis.charts.chart import Chart, Panel
from pmwvc_analysis.charts.chart_data import payload
from pmwvc_analysis.figures import recorded
from pmwvc_analysis.figures.recorded import Event, numbered
from pmwvc_analysis.prediction import text as prediction_text
from pmwvc_analysis.report.loop_blocks import blocks, rendered
from pmwvc_analysis.report.loop_drawing import drawing
from pmwvc_analysis.report.page import filled
from pmwvc_analysis.report.story import story
from pmwvc_analysis.traces.stages import until
from pmwvc_analysis.verdicts.passivity import budget_lines, passivity
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
    folder: str = "",
    replay: str | None = None,
) -> str:
    """Return the report as HTML; parts that the session does not have are left out.

    ``folder`` is the session's, for the command that plays it on the page, ``replay`` the page's
    file beside the report.
    """
    found = passivity(until(traces, summary["judged_until_s"]), scenario, energies)
    traces = replace(traces, events=summary["events"])
    events = numbered(traces)
    waves = scenario is not None and has_waves(scenario.controller)
    chart_data, complete = figure_data(charts, traces, events)
    return filled(
        TEMPLATE,
        title=scenario.name if scenario else "recorded session",
        description=scenario.description if scenario else "",
        folder=folder,
        replay=replay,
        summary=summary,
        story=story(traces, scenario, summary, energies),
        loops=[
            (
                user.name,
                drawing(blocks(scenario, user, energies), name=user.name, waves=waves),
                rendered(scenario, user, live=traces.live),
            )
            for user in scenario.users
        ]
        if scenario
        else [],
        verdicts=[(line["ok"], line["text"]) for line in summary["verdict"]],
        budget_owners=[*energies.hands, "server"] if energies else [],
        budget_rows=energies.rows() if energies else [],
        budget_lines=budget_lines(energies, found) if energies else [],
        budget_notes=energies.notes if energies else [],
        events=events[:MOST_EVENTS],
        more_events=max(0, len(events) - MOST_EVENTS),
        predicted=prediction_text.lines(scenario, live=traces.live) if scenario else [],
        outcome=[(entry["hit"], entry["text"]) for entry in summary["outcomes"]],
        figures=figure_blocks(charts, traces),
        hatches=chart_svg.hatches(),
        chart_data=chart_data,
        complete=complete,
        parameters=scenario.flat() if scenario else {},
        software=traces.metadata.get("software", {}),
    )


class PanelBlock(NamedTuple):
    """One panel, its legend and its drawing: markup, with all text in it escaped, is in ``svg``
    and the samples of ``entries`` only.
    """

    panel: Panel
    entries: list[tuple[str, str]]  # label, sample
    bands: list[str]
    levels: list[str]
    height: float
    svg: str


def figure_blocks(
    charts: Sequence[Chart], traces: SessionTraces
) -> list[tuple[Chart, list[PanelBlock]]]:
    """Return the figures of a report, each with its panels."""
    span = recorded.span(traces)

    def block(chart: Chart, index: int) -> PanelBlock:
        panel, labelled = chart.panels[index], chart.labelled(index)
        own = chart.x_span(index, span)
        return PanelBlock(
            panel,
            [(each.label, chart_svg.sample(each)) for each in chart_svg.entries(panel)],
            list(dict.fromkeys(band.label for band in panel.bands)),
            list(dict.fromkeys(level.label for level in panel.levels)),
            chart_svg.panel_height(panel, labelled=labelled),
            chart_svg.panel_svg(panel, span=own, events=chart.events, labelled=labelled),
        )

    return [(chart, [block(chart, i) for i in range(len(chart.panels))]) for chart in charts]


def figure_data(
    charts: Sequence[Chart], traces: SessionTraces, events: Sequence[Event]
) -> tuple[str, bool]:
    """Return the data as JSON that can stand in a page, and whether every point is in it."""
    marks: list[Sequence[Any]] = [
        (each.time_s, each.number, f"{each.number}. {each.time_s:.3f} s: {each.who} {each.what}")
        for each in events
        if each.time_s is not None
    ]
    found, complete = payload(charts, recorded.span(traces), marks)
    text = json.dumps(found, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c"), complete
