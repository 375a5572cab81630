# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Figures on disk, the panels of a chart on white: PNG and SVG by matplotlib."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pmwvc_analysis.charts import style
from pmwvc_analysis.charts.chart import Chart, Dots, Layer, Line, Panel, Span
from pmwvc_analysis.charts.chart_data import reduced
from pmwvc_analysis.charts.style import LIGHT

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLUMNS = 2000
MOST_VECTORS = 2000  # dots of an SVG; more are a picture in it
MARKERS = {"dot": (".", 2.5), "ring": ("o", 5.0), "cross": ("x", 5.0), "plus": ("+", 5.0)}
HATCHES = ("", "///", "\\\\\\", "---", "|||", "xxx", "...", "+++")


def write(
    chart: Chart, folder: Path, span: Span | None = None, *, kinds: Sequence[str] = ("png", "svg")
) -> list[Path]:
    """Write a figure as ``NAME.png`` and ``NAME.svg``; return both.

    ``span`` is the range of the time axis [s]; that of the curves by default.
    """
    import matplotlib

    with matplotlib.rc_context(style.SETTINGS):
        return style.save(figure(chart, span), folder, chart.name, kinds)


def figure(chart: Chart, span: Span | None = None) -> "Figure":
    """Return the matplotlib figure of a chart."""
    heights = [panel.height for panel in chart.panels]
    drawn, rows = style.canvas(heights, title=chart.title, note=chart.note)
    for index, (axes, panel) in enumerate(zip(rows, chart.panels, strict=True)):
        _panel(axes, panel, chart.x_span(index, span), labelled=chart.labelled(index))
        for time_s, number in chart.events if panel.of_time else ():
            axes.axvline(time_s, color=LIGHT["soft"], lw=0.7, ls=":")
            axes.annotate(number, (time_s, 1.0), xycoords=("data", "axes fraction"),
                          color=LIGHT["soft"], fontsize=8, va="top")  # fmt: skip
    return drawn


def _panel(axes: "Axes", panel: Panel, span: Span, *, labelled: bool) -> None:
    for index, band in enumerate(panel.bands):
        known = band.label in {each.label for each in panel.bands[:index]}
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
    for index, level in enumerate(panel.levels):
        label = None if index else level.label
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
    if panel.x_names:
        axes.set_xticks(range(len(panel.x_names)), panel.x_names)
    if labelled:
        axes.set_xlabel(panel.x_label)
    else:
        axes.tick_params(labelbottom=False)
    style.legend(axes)


def _line(axes: "Axes", line: Line, column: float) -> None:
    parts = reduced(line.x, line.y, period=line.period, column=column)
    hole = np.array([-1])
    rows = np.concatenate([hole, *(each for part in parts for each in (part, hole))])
    x, y = line.x[rows], np.where(rows < 0, np.nan, line.y[rows])
    width = line.width / 1.25
    (drawn,) = axes.plot(x, y, color=LIGHT[line.tint], lw=width, label=line.label)
    if line.dash:
        drawn.set_linestyle((0, tuple(each / line.width for each in line.dash)))


def _dots(axes: "Axes", dots: Dots) -> None:
    marker, size = MARKERS[dots.mark]
    axes.plot(
        dots.x,
        dots.y,
        ls="",
        marker=marker,
        ms=size,
        mfc="none" if dots.mark == "ring" else None,
        color=LIGHT[dots.tint],
        label=dots.label,
        rasterized=len(dots.x) > MOST_VECTORS,
    )


def _layer(axes: "Axes", layer: Layer, label: str | None) -> None:
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
