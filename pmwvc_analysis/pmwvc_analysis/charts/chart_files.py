# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The renderings of a chart: PNG and SVG by matplotlib, and the numbers from which ``chart.js``
draws it in a report: every point, or of a long one the extremes of each stretch of time.
"""

import base64
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pmwvc_analysis.charts import style
from pmwvc_analysis.charts.chart import Chart, Curve, Dots, Panel, Span
from pmwvc_analysis.charts.style import LIGHT
from pmwvc_core.numeric import Array, Integers

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLUMNS = 2000
MOST_VECTORS = 2000  # dots of an SVG; more are a picture in it
MARKERS = {"dot": (".", 2.5), "ring": ("o", 5.0), "cross": ("x", 5.0), "plus": ("+", 5.0)}
CLOSE = 0.03  # of the span: numbers of events lie over each other
MOST_NUMBERS = 320_000  # in all figures of a report together: 1.7 MB of text
LEAST_POINTS = 2_000  # of a curve, however many there are


def write(
    chart: Chart, folder: Path, span: Span | None = None, *, kinds: Sequence[str] = ("png", "svg")
) -> list[Path]:
    """Write a figure as ``NAME.png`` and ``NAME.svg``; ``span``: of its time [s], else all."""
    import matplotlib

    with matplotlib.rc_context(style.SETTINGS):
        return style.save(figure(chart, span), folder, chart.name, kinds)


def figure(chart: Chart, span: Span | None = None) -> "Figure":
    """Return the matplotlib figure of a chart; panels of the same quantity share their axis."""
    heights = [panel.height for panel in chart.panels]
    drawn, rows = style.canvas(heights, title=chart.title, note=chart.note)
    first: dict[str, Axes] = {}
    for index, (axes, panel) in enumerate(zip(rows, chart.panels, strict=True)):
        if first.setdefault(panel.x_label, axes) is not axes:
            axes.sharex(first[panel.x_label])
        _panel(axes, panel)
        if chart.labelled(index):
            axes.set_xlabel(panel.x_label)
        else:
            axes.tick_params(labelbottom=False)
        if panel.of_time:
            axes.set_xlim(span)
    for axes, panel in zip(rows, chart.panels, strict=True):
        if panel.of_time:
            _events(axes, chart.events)
    return drawn


def _events(axes: "Axes", events: Sequence[tuple[float, str]]) -> None:
    """Draw events; of those too close for a number each the first has one."""
    close, numbered_s = CLOSE * float(np.ptp(axes.get_xlim())), -math.inf
    for time_s, number in events:
        axes.axvline(time_s, color=LIGHT["soft"], lw=0.7, ls=":")
        if time_s - numbered_s > close:
            numbered_s = time_s
            axes.annotate(
                number,
                (time_s, 1.0),
                xycoords=("data", "axes fraction"),
                color=LIGHT["soft"],
                fontsize=8,
                va="top",
            )


def _panel(axes: "Axes", panel: Panel) -> None:
    axes.margins(x=0.0)
    axes.set(
        ylabel=panel.y_label,
        xscale="log" if panel.x_log else "linear",
        yscale="log" if panel.y_log else "linear",
    )
    for band in panel.bands:
        look: dict[str, Any] = {"color": LIGHT[band.tint], "hatch": "///", "alpha": 0.18}
        axes.axvspan(*band.span, linewidth=0.0, label=band.label, **look)
    for line in panel.lines:
        x, y = _interrupted(line)
        dash = (0, tuple(each / line.width for each in line.dash)) if line.dash else "-"
        look = {"color": LIGHT[line.tint], "lw": line.width / 1.25, "ls": dash}
        axes.plot(x, y, label=line.label, **look)
    for dots in panel.dots:
        marker, size = MARKERS[dots.mark]
        look = {"marker": marker, "ms": size, "color": LIGHT[dots.tint], "label": dots.label}
        look |= {"mfc": "none"} if dots.mark == "ring" else {}
        axes.plot(dots.x, dots.y, ls="", rasterized=len(dots.x) > MOST_VECTORS, **look)
    for level in panel.levels:
        axes.axhline(level.y, color=LIGHT[level.tint], lw=1.0, ls=":", label=level.label)
    if panel.with_zero:
        axes.axhline(0.0, color=LIGHT["object"], lw=0.8)
    if panel.title:
        axes.set_title(panel.title, color=LIGHT[panel.tint], fontweight="bold")
    if panel.x_names:
        axes.set_xticks(range(len(panel.x_names)), panel.x_names)
        axes.set_xlim(-0.5, len(panel.x_names) - 0.5)
    if panel.y_range:
        axes.set_ylim(panel.y_range)
    style.legend(axes)


def _interrupted(line: Curve) -> tuple[Array, Array]:
    """Return a curve with a NaN in each of its gaps; one narrower than a column is none."""
    if not line.period or not len(line.x):
        return line.x, line.y
    longest = max(1.5 * line.period, float(line.x[-1] - line.x[0]) / COLUMNS)
    gaps = np.flatnonzero(np.diff(line.x) > longest) + 1
    return np.insert(line.x, gaps, np.nan), np.insert(line.y, gaps, np.nan)


Arrays = dict[str, int]  # of a report by content, each once: its number


def _stored(values: Array, arrays: Arrays) -> int:
    """Store an array and return its number."""
    single = np.ascontiguousarray(values, dtype="<f4")
    return arrays.setdefault(base64.b64encode(single.tobytes()).decode(), len(arrays))


def payload(
    charts: Sequence[Chart], span: Span, events: Sequence[Sequence[Any]]
) -> tuple[dict[str, Any], bool]:
    """Return the data of all figures, and whether every point is there."""
    panels = [panel for chart in charts for panel in chart.panels]
    curves = [len(line.x) for panel in panels for line in panel.lines]
    curves += [len(dots.x) for panel in panels for dots in panel.dots]
    most = max(curves, default=0)
    if 2 * sum(curves) > MOST_NUMBERS:
        most = max(LEAST_POINTS, MOST_NUMBERS // (2 * len(curves)))
    arrays: Arrays = {}
    found = [
        {"name": chart.name, "heading": chart.heading}
        | {"panels": [_fields(panel, arrays, most) for panel in chart.panels]}
        for chart in charts
    ]
    data = {"span": span, "events": events, "charts": found, "arrays": [*arrays]}
    return data, all(length <= most for length in curves)


def thinned(x: Array, y: Array, *, period: float, most: int) -> Integers:
    """Return the indices of at most ``most`` points or so: of each column of the picture, and of
    each stretch without a gap, the first, the last, the least and the largest; one of each hole.
    """
    if len(x) <= most:
        return np.arange(len(x))
    hole = ~np.isfinite(y)
    column = float(np.nanmax(x) - np.nanmin(x)) / max(1, most // 4)
    columns = np.where(hole, -1.0, np.floor((x - np.nanmin(x)) / column))
    new = (np.diff(columns) != 0.0) | (np.diff(x) > (1.5 * period or math.inf))
    group = np.concatenate([[0], np.cumsum(new & ~(hole[1:] & hole[:-1]))])
    begins = np.flatnonzero(np.diff(group, prepend=-1))
    ends = np.append(begins[1:], len(x)) - 1
    by_size = np.lexsort((y, group))
    kept = np.stack([begins, ends, by_size[begins], by_size[ends]])
    kept[:, hole[begins]] = begins[hole[begins]]
    return np.unique(kept)


def _fields(panel: Panel, arrays: Arrays, most: int) -> dict[str, Any]:
    """Return the fields of a panel and of all it shows; arrays by their numbers."""
    kinds = ("lines", "dots", "bands", "levels")
    shown = {kind: [_shown(each, arrays, most) for each in getattr(panel, kind)] for kind in kinds}
    return vars(panel) | shown | {"of_time": panel.of_time}


def _shown(each: Any, stored: Arrays, most: int) -> dict[str, Any]:
    fields: dict[str, Any] = {**vars(each)}
    rows: Integers | slice = slice(None)
    if isinstance(each, (Curve, Dots)):
        period = each.period if isinstance(each, Curve) else math.inf
        rows = thinned(each.x, each.y, period=period, most=most)
        if 0.0 < period < math.inf and len(rows) < len(each.x):
            # only a gap beyond the thinned steps is one
            fields |= {"period": max(period, float(np.ptp(each.x)) / max(1, most // 4))}
    arrays = fields.items()
    return fields | {n: _stored(v[rows], stored) for n, v in arrays if isinstance(v, np.ndarray)}
