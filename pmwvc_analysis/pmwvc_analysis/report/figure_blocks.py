# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The figures of a session as parts of its report: markup that shows them without a script, and
the data with which ``chart.js`` lets the reader zoom.
"""

import json
from collections.abc import Sequence
from typing import Any, NamedTuple

from pmwvc_analysis.charts import chart_svg
from pmwvc_analysis.charts.chart import Chart, Panel, Span
from pmwvc_analysis.charts.chart_data import payload
from pmwvc_analysis.figures import recorded
from pmwvc_analysis.figures.recorded import Event
from pmwvc_core.traces import SessionTraces


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
    return [
        (chart, [_block(chart, index, span) for index in range(len(chart.panels))])
        for chart in charts
    ]


def _block(chart: Chart, index: int, span: Span) -> PanelBlock:
    panel, labelled = chart.panels[index], chart.labelled(index)
    return PanelBlock(
        panel,
        [(each.label, chart_svg.sample(each)) for each in chart_svg.entries(panel)],
        list(dict.fromkeys(band.label for band in panel.bands)),
        list(dict.fromkeys(level.label for level in panel.levels)),
        chart_svg.panel_height(panel, labelled=labelled),
        chart_svg.panel_svg(
            panel, span=chart.x_span(index, span), events=chart.events, labelled=labelled
        ),
    )


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
