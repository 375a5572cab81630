# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Figures on disk, the panels of a chart on white: PNG and SVG by matplotlib."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pmwvc_analysis.charts import style
from pmwvc_analysis.charts.chart import Chart, Line, Panel, Span
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
    for band in panel.bands:
        tint = LIGHT[band.tint]
        look: dict[str, Any] = {
            "facecolor": tint,
            "edgecolor": tint,
            "hatch": "///",
            "alpha": 0.18,
        }
        axes.axvspan(*band.span, linewidth=0.0, label=band.label, **look)
    for layer in panel.layers:
        look = {"facecolor": LIGHT[layer.tint], "edgecolor": "white", "alpha": 0.75}
        look |= {"hatch": HATCHES[layer.hatch], "linewidth": 0.0, "label": layer.label}
        axes.fill_between(layer.x, layer.low, layer.high, **look)
    for line in panel.lines:
        _line(axes, line, (span[1] - span[0]) / COLUMNS if not panel.x_log else 0.0)
    for dots in panel.dots:
        marker, size = MARKERS[dots.mark]
        look = {"marker": marker, "ms": size, "color": LIGHT[dots.tint], "label": dots.label}
        look |= {"mfc": "none"} if dots.mark == "ring" else {}
        axes.plot(dots.x, dots.y, ls="", rasterized=len(dots.x) > MOST_VECTORS, **look)
    for level in panel.levels:
        axes.axhline(level.y, color=LIGHT[level.tint], lw=1.0, ls=":", label=level.label)
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
    (drawn,) = axes.plot(x, y, color=LIGHT[line.tint], lw=line.width / 1.25, label=line.label)
    if line.dash:
        drawn.set_linestyle((0, tuple(each / line.width for each in line.dash)))
