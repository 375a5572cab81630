# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A figure as PNG, for slides and documents: the panels of a chart on white."""

from pathlib import Path
from typing import Any

import numpy as np

from pmwvc_analysis.charts import style
from pmwvc_analysis.charts.chart import Chart, Dots, Layer, Line, Panel, Span
from pmwvc_analysis.charts.colours import LIGHT
from pmwvc_analysis.charts.decimate import reduced

COLUMNS = 2000
MARKERS = {"dot": (".", 2.5), "cross": ("x", 5.0), "plus": ("+", 5.0)}
HATCHES = ("", "///", "\\\\\\", "---", "|||", "xxx", "...", "+++")


def write(chart: Chart, path: Path, span: Span) -> Path:
    """Draw a chart and write it."""
    import matplotlib

    with matplotlib.rc_context(style.SETTINGS):
        return style.save(figure(chart, span), path)


def figure(chart: Chart, span: Span) -> Any:
    """Return the matplotlib figure of a chart."""
    heights = [panel.height for panel in chart.panels]
    drawn, rows = style.canvas(
        len(heights), title=chart.title, note=chart.note, share="none", heights=heights
    )
    last = len(rows) - 1
    for place, (axes, panel) in enumerate(zip(rows, chart.panels, strict=True)):
        labelled = place == last or not panel.of_time
        _panel(axes, panel, span if panel.of_time else panel.x_span(), labelled=labelled)
        for time_s, _ in chart.events if panel.of_time else ():
            axes.axvline(time_s, color=LIGHT["soft"], lw=0.7, ls=":")
    return drawn


def _panel(axes: Any, panel: Panel, span: Span, *, labelled: bool) -> None:
    for place, band in enumerate(panel.bands):
        known = band.label in {each.label for each in panel.bands[:place]}
        axes.axvspan(
            *band.span,
            facecolor=LIGHT[band.tint],
            alpha=0.18,
            hatch="///",
            edgecolor=LIGHT[band.tint],
            linewidth=0.0,
            label=None if known else band.label,
        )
    named: set[str] = set()
    for layer in panel.layers:
        _layer(axes, layer, None if layer.label in named else layer.label)
        named.add(layer.label)
    for line in panel.lines:
        _line(axes, line, (span[1] - span[0]) / COLUMNS if not panel.x_log else 0.0)
    for dots in panel.dots:
        _dots(axes, dots)
    for place, level in enumerate(panel.levels):
        label = None if place else level.label
        axes.axhline(level.y, color=LIGHT[level.tint], lw=1.0, ls=":", label=label)
    if panel.with_zero:
        axes.axhline(0.0, color=LIGHT["object"], lw=0.8)
    for note in panel.notes:
        axes.annotate(note.text, (note.x, note.y), color=LIGHT["alarm"], fontsize=9, ha="right")
    if panel.title:
        axes.set_title(panel.title, color=LIGHT[panel.tint], fontweight="bold")
    axes.set(ylabel=panel.y_label, xlim=span, ylim=panel.y_span())
    axes.set_xscale("log" if panel.x_log else "linear")
    axes.set_yscale("log" if panel.y_log else "linear")
    if labelled:
        axes.set_xlabel(panel.x_label)
    else:
        axes.tick_params(labelbottom=False)
    style.legend(axes)


def _line(axes: Any, line: Line, column: float) -> None:
    parts = reduced(line.x, line.y, period=line.period, column=column)
    hole = np.array([-1])
    rows = np.concatenate([hole, *(each for part in parts for each in (part, hole))])
    x, y = line.x[rows], np.where(rows < 0, np.nan, line.y[rows])
    ls: Any = (0, tuple(each / line.width for each in line.dash)) if line.dash else "-"
    axes.plot(x, y, color=LIGHT[line.tint], lw=line.width / 1.25, ls=ls, label=line.label)


def _dots(axes: Any, dots: Dots) -> None:
    marker, size = MARKERS[dots.mark]
    axes.plot(
        dots.x, dots.y, ls="", marker=marker, ms=size, color=LIGHT[dots.tint], label=dots.label
    )


def _layer(axes: Any, layer: Layer, label: str | None) -> None:
    axes.fill_between(
        layer.x,
        layer.low,
        layer.high,
        facecolor=LIGHT[layer.tint],
        alpha=0.75,
        hatch=HATCHES[layer.hatch],
        edgecolor="white",
        linewidth=0.0,
        label=label,
    )
