# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The figures of a session as parts of its report: markup that shows them without a script, and
the data with which ``chart.js`` lets the reader zoom.
"""

import json
from collections.abc import Sequence
from typing import Any, NamedTuple

from pmwvc_analysis.charts import chart_svg
from pmwvc_analysis.charts.chart import Chart, Span
from pmwvc_analysis.charts.chart_data import payload
from pmwvc_analysis.figures import recorded
from pmwvc_analysis.figures.recorded import Event
from pmwvc_core.traces import SessionTraces


class Entry(NamedTuple):
    """One entry of a legend; markup is in ``sample`` and ``svg`` only, all text in it escaped."""

    label: str
    sample: str


class PanelBlock(NamedTuple):
    """One panel: its heading, legend and drawing."""

    title: str
    tint: str
    y_label: str
    entries: list[Entry]
    bands: list[str]
    levels: list[str]
    height: float
    svg: str


class FigureBlock(NamedTuple):
    """One figure."""

    name: str
    heading: str
    caption: str
    panels: list[PanelBlock]


def figure_blocks(charts: Sequence[Chart], traces: SessionTraces) -> list[FigureBlock]:
    """Return the figures of a report."""
    span = recorded.span(traces)
    return [
        FigureBlock(chart.name, chart.heading, chart.caption, _panels(chart, span))
        for chart in charts
    ]


def _panels(chart: Chart, span: Span) -> list[PanelBlock]:
    found = []
    for index, panel in enumerate(chart.panels):
        labelled = chart.labelled(index)
        drawing = chart_svg.panel_svg(
            panel, span=chart.x_span(index, span), events=chart.events, labelled=labelled
        )
        found.append(
            PanelBlock(
                panel.title,
                panel.tint,
                panel.y_label,
                [Entry(each.label, chart_svg.sample(each)) for each in chart_svg.entries(panel)],
                list(dict.fromkeys(band.label for band in panel.bands)),
                list(dict.fromkeys(level.label for level in panel.levels)),
                chart_svg.panel_height(panel, labelled=labelled),
                drawing,
            )
        )
    return found


def data(
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
