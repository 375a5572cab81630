# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A figure as an SVG file of its own: title, panels with legends, note; on white."""

import textwrap
from html import escape

from pmwvc_analysis.charts.chart import Chart, Panel, Span
from pmwvc_analysis.charts.chart_svg import (
    WIDTH,
    entries,
    hatches,
    literal,
    panel_height,
    panel_svg,
    sample,
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
    style = f"fill:{literal(panel.tint)};font-weight:700"
    out = [f'<text x="8" y="18" style="{style}">{escape(head)}</text>']
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
