# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Figures on disk, the panels of a chart on white: PNG by matplotlib, and SVG beside it."""

import textwrap
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pmwvc_analysis.charts import style
from pmwvc_analysis.charts.chart import Chart, Dots, Layer, Line, Panel, Span
from pmwvc_analysis.charts.chart_svg import (
    WIDTH,
    entries,
    hatches,
    literal,
    panel_height,
    panel_svg,
    sample,
)
from pmwvc_analysis.charts.decimate import reduced
from pmwvc_analysis.charts.style import LIGHT

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLUMNS = 2000
MARKERS = {"dot": (".", 2.5), "ring": ("o", 5.0), "cross": ("x", 5.0), "plus": ("+", 5.0)}
HATCHES = ("", "///", "\\\\\\", "---", "|||", "xxx", "...", "+++")


def write(chart: Chart, folder: Path, span: Span | None = None) -> list[Path]:
    """Write a figure as ``NAME.png`` and ``NAME.svg``; return both.

    ``span`` is the range of the time axis [s]; that of the curves by default.
    """
    import matplotlib

    png, svg = (folder / f"{chart.name}.{kind}" for kind in ("png", "svg"))
    with matplotlib.rc_context(style.SETTINGS):
        style.save(figure(chart, span), png)
    svg.write_text(file_svg(chart, span), encoding="utf-8")
    return [png, svg]


def figure(chart: Chart, span: Span | None = None) -> "Figure":
    """Return the matplotlib figure of a chart."""
    heights = [panel.height for panel in chart.panels]
    drawn, rows = style.canvas(heights, title=chart.title, note=chart.note)
    for index, (axes, panel) in enumerate(zip(rows, chart.panels, strict=True)):
        _panel(axes, panel, chart.x_span(index, span), labelled=chart.labelled(index))
        for time_s, _ in chart.events if panel.of_time else ():
            axes.axvline(time_s, color=LIGHT["soft"], lw=0.7, ls=":")
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


KEY, HEAD, FOOT = 26.0, 40.0, 30.0  # heights: legend of a panel, title and note of a file
LETTER = 6.6  # mean width of a letter of 12 px
STYLE = (
    "text{font:12px system-ui,'DejaVu Sans',sans-serif}"
    ".line,.dots,.grid,.ev,.sample{fill:none}.dots{stroke-linecap:round;stroke-width:2.6}"
    ".dots.cross,.dots.plus,.dots.ring{stroke-width:1.4}.line{stroke-linejoin:round}"
)


def file_svg(chart: Chart, span: Span | None = None) -> str:
    """Return the file of a figure; ``span`` is the range of the time axis [s]."""
    out, top = [], HEAD
    for index, panel in enumerate(chart.panels):
        labelled = chart.labelled(index)
        key, rows = _key(panel)
        inner = panel_svg(
            panel,
            span=chart.x_span(index, span),
            events=chart.events,
            labelled=labelled,
            paint=literal,
        )
        body = top + KEY * rows
        out.append(f'<g transform="translate(0 {top:g})">{key}</g>')
        out.append(f'<g transform="translate(0 {body:g})">{inner}</g>')
        top = body + panel_height(panel, labelled=labelled) + 6.0
    notes = textwrap.wrap(chart.note, round(WIDTH / LETTER))
    lines = "".join(
        f'<text x="8" y="{top + 14 + 15 * row:g}" style="fill:{literal("soft")};font-size:11px">'
        f"{escape(text)}</text>"
        for row, text in enumerate(notes)
    )
    height = top + FOOT + 15 * max(0, len(notes) - 1)
    size = f'viewBox="0 0 {WIDTH:g} {height:g}" width="{WIDTH:g}" height="{height:g}"'
    heading = f'<text x="8" y="24" style="font-size:16px;font-weight:700">{escape(chart.title)}'
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" {size}><style>{STYLE}</style>'
        f"<defs>{hatches(literal)}</defs>"
        f'<rect width="100%" height="100%" style="fill:{literal("paper")}"/>'
        f"{heading}</text>{''.join(out)}{lines}</svg>\n"
    )


def _key(panel: Panel) -> tuple[str, int]:
    """Return the legend above a panel and how many rows it takes."""
    head = " · ".join(text for text in (panel.title, panel.y_label) if text)
    css = f"fill:{literal(panel.tint)};font-weight:700"
    out = [f'<text x="8" y="18" style="{css}">{escape(head)}</text>']
    across, row = 28.0 + LETTER * 1.15 * len(head), 0
    for each in entries(panel):
        need = 38.0 + LETTER * len(each.label)
        if across + need > WIDTH:
            across, row = 28.0, row + 1
        shift = f"translate({across:g} {8 + KEY * row:g})"
        out.append(
            f'<g transform="{shift}">{sample(each, literal)}'
            f'<text x="31" y="10">{escape(each.label)}</text></g>'
        )
        across += need
    return "".join(out), row + 1
