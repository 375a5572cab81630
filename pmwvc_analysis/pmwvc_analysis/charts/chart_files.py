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
from pmwvc_analysis.charts.chart import Chart, Curve, Panel, Span
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
HATCHES = ("", "///", "\\\\\\", "---", "|||", "xxx", "...", "+++")


def write(
    chart: Chart, folder: Path, span: Span | None = None, *, kinds: Sequence[str] = ("png", "svg")
) -> list[Path]:
    """Write a figure as ``NAME.png`` and ``NAME.svg``; ``span``: of its time [s], else all."""
    import matplotlib

    with matplotlib.rc_context(style.SETTINGS):
        return style.save(figure(chart, span), folder, chart.name, kinds)


def figure(chart: Chart, span: Span | None = None) -> "Figure":
    """Return the matplotlib figure of a chart."""
    heights = [panel.height for panel in chart.panels]
    drawn, rows = style.canvas(heights, title=chart.title, note=chart.note)
    for index, (axes, panel) in enumerate(zip(rows, chart.panels, strict=True)):
        _panel(axes, panel, chart.x_span(index, span), labelled=chart.labelled(index))
        if panel.of_time:
            _events(axes, chart.events, chart.x_span(index, span))
    return drawn


def _events(axes: "Axes", events: Sequence[tuple[float, str]], span: Span) -> None:
    """Draw events; those too close for a number each have the first and the last one."""
    together: list[list[tuple[float, str]]] = []
    for event in events:
        axes.axvline(event[0], color=LIGHT["soft"], lw=0.7, ls=":")
        if not together or event[0] - together[-1][0][0] > CLOSE * (span[1] - span[0]):
            together.append([])
        together[-1].append(event)
    for (time_s, number), *others in together:
        text = f"{number}-{others[-1][1]}" if others else number
        axes.annotate(text, (time_s, 1.0), xycoords=("data", "axes fraction"),
                      color=LIGHT["soft"], fontsize=8, va="top")  # fmt: skip


def _panel(axes: "Axes", panel: Panel, span: Span, *, labelled: bool) -> None:
    for band in panel.bands:
        look: dict[str, Any] = {"color": LIGHT[band.tint], "hatch": "///", "alpha": 0.18}
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


def _line(axes: "Axes", line: Curve, column: float) -> None:
    parts = reduced(line.x, line.y, period=line.period, column=column)
    hole = np.array([-1])
    rows = np.concatenate([hole, *(each for part in parts for each in (part, hole))])
    x, y = line.x[rows], np.where(rows < 0, np.nan, line.y[rows])
    (drawn,) = axes.plot(x, y, color=LIGHT[line.tint], lw=line.width / 1.25, label=line.label)
    if line.dash:
        drawn.set_linestyle((0, tuple(each / line.width for each in line.dash)))


class Pool:
    """Arrays of a report, each stored once; evenly stepped ones as start, step and count."""

    def __init__(self) -> None:
        self.stored: list[Any] = []
        self._known: dict[bytes, int] = {}

    def put(self, values: Array) -> int:
        """Store an array and return its number."""
        single = np.ascontiguousarray(values, dtype="<f4")
        content = single.tobytes()
        if content not in self._known:
            self._known[content] = len(self.stored)
            self.stored.append(_even(np.asarray(values)) or base64.b64encode(content).decode())
        return self._known[content]


def _even(values: Array) -> list[float] | None:
    if len(values) < 8 or not np.isfinite(values).all():
        return None
    step = float(values[-1] - values[0]) / (len(values) - 1)
    even = float(values[0]) + step * np.arange(len(values))
    if step <= 0.0 or np.abs(values - even).max() > 1e-4 * step:
        return None
    return [float(values[0]), step, len(values)]


def payload(
    charts: Sequence[Chart], span: Span, events: Sequence[Sequence[Any]]
) -> tuple[dict[str, Any], bool]:
    """Return the data of all figures, and whether every point is there."""
    curves = [len(x) for chart in charts for panel in chart.panels for x, _ in panel.curves()]
    left, waiting, most = MOST_NUMBERS, sorted(curves), max(curves, default=0)
    for index, length in enumerate(waiting):  # all points, while all together are few enough
        fair = left // (2 * (len(waiting) - index))
        if length > fair:
            most = max(LEAST_POINTS, fair)
            break
        left -= 2 * length
    pool = Pool()
    found = [
        {"name": chart.name, "heading": chart.heading}
        | {"panels": [_fields(panel, pool, most) for panel in chart.panels]}
        for chart in charts
    ]
    data = {"span": span, "events": events, "charts": found, "arrays": pool.stored}
    return data, all(length <= most for length in curves)


def thinned(x: Array, y: Array, *, period: float, most: int) -> Integers:
    """Return the indices of at most ``most`` points or so, extremes and ends of gaps included."""
    if len(x) <= most:
        return np.arange(len(x))
    rows = np.flatnonzero(np.isfinite(x))
    column = float(x[rows].max() - x[rows].min()) / max(1, most // 4)
    parts = [
        envelope(x, y, part, column=column) for part in segments(x, y, longest_step=1.5 * period)
    ]
    gaps = np.flatnonzero(~np.isfinite(y))  # keep one of each hole, so that it stays one
    gaps = gaps[np.diff(gaps, prepend=-9) > 1]
    return np.unique(np.concatenate([gaps, *parts]))


def _fields(panel: Panel, pool: Pool, most: int) -> dict[str, Any]:
    """Return the fields of a panel and of all it shows; arrays by their numbers."""
    lines, dots = [], []
    for line in panel.lines:
        rows = thinned(line.x, line.y, period=line.period, most=most)
        step = line.period
        if len(rows) < len(line.x) and step > 0.0:  # only a gap beyond the thinned steps is one
            step = max(step, float(np.nanmax(line.x) - np.nanmin(line.x)) / max(1, most // 4))
        points = {"x": pool.put(line.x[rows]), "y": pool.put(line.y[rows])}
        lines.append(vars(line) | points | {"period": step})
    for each in panel.dots:
        rows = thinned(each.x, each.y, period=math.inf, most=most)
        dots.append(vars(each) | {"x": pool.put(each.x[rows]), "y": pool.put(each.y[rows])})
    layers = [
        vars(layer) | {name: pool.put(getattr(layer, name)) for name in ("x", "low", "high")}
        for layer in panel.layers
    ]
    plain = {name: list(map(vars, getattr(panel, name))) for name in ("bands", "levels", "notes")}
    drawn = {"lines": lines, "dots": dots, "layers": layers, "of_time": panel.of_time}
    return vars(panel) | plain | drawn


def segments(x: Array, y: Array, *, longest_step: float) -> list[Integers]:
    """Return the indices of each stretch without NaN or a longer step (0: of any length)."""
    rows = np.flatnonzero(np.isfinite(x) & np.isfinite(y))
    if not len(rows):
        return []
    breaks = np.diff(rows) > 1
    if longest_step > 0.0:
        breaks |= np.diff(x[rows]) > longest_step
    return np.split(rows, np.flatnonzero(breaks) + 1)


def envelope(x: Array, y: Array, rows: Integers, *, column: float) -> Integers:
    """Return which of ``rows`` to draw where a column of the picture is ``column`` wide."""
    if len(rows) <= 4 or column <= 0.0:
        return rows
    columns = np.floor((x[rows] - x[rows[0]]) / column)
    starts = np.concatenate([[0], np.flatnonzero(np.diff(columns)) + 1])
    if len(starts) > len(rows) / 4:
        return rows
    ends = np.concatenate([starts[1:], [len(rows)]])
    kept = [starts, ends - 1]
    values = y[rows]
    for extreme in (np.argmin, np.argmax):
        pairs = zip(starts, ends, strict=True)
        kept.append(np.array([start + extreme(values[start:end]) for start, end in pairs]))
    return np.asarray(rows[np.unique(np.concatenate(kept))])


def reduced(x: Array, y: Array, *, period: float, column: float) -> list[Integers]:
    """Return the indices of each stretch to draw; a gap narrower than a column is none."""
    step = max(1.5 * period, column) if period > 0.0 else 0.0
    return [envelope(x, y, part, column=column) for part in segments(x, y, longest_step=step)]
