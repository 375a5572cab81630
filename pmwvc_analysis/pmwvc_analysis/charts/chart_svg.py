# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The panels of a figure as SVG for the report, in colours of a page that knows light and dark.

``chart.js`` draws the same panels anew when the reader zooms: what changes here changes there.
"""

from collections.abc import Sequence
from html import escape

import numpy as np

from pmwvc_analysis.charts.axis import Axis, reduced
from pmwvc_analysis.charts.chart import Dots, Layer, Line, Note, Panel, Span
from pmwvc_core.numeric import Array

WIDTH = 1000.0
LEFT, RIGHT, TOP, BOTTOM = 56.0, 10.0, 6.0, 34.0
NAME = 14  # height of a line of a name
MARKS = {
    "dot": "h0",
    "cross": "m-3-3l6 6m0-6l-6 6",
    "plus": "m-3 0h6m-3-3v6",
    "ring": "m-3 0a3 3 0 1 0 6 0a3 3 0 1 0-6 0",
}
HATCHES = (
    "", "M0 8L8 0", "M0 0L8 8", "M0 4H8", "M4 0V8", "M0 8L8 0M0 0L8 8", "M4 4h.1", "M0 4H8M4 0V8",
)  # fmt: skip


def paint(tint: str) -> str:
    """Return a colour of the page."""
    return f"var(--c-{tint})"


def panel_svg(
    panel: Panel, *, span: Span, events: Sequence[tuple[float, str]] = (), labelled: bool = True
) -> str:
    """Return the markup of one panel, ``WIDTH`` wide and ``panel_height`` high."""
    bottom = TOP + panel.height
    x = Axis(*span, LEFT, WIDTH - RIGHT, panel.x_log)
    y = Axis(*panel.y_span(), bottom, TOP, panel.y_log)
    soft, grid = paint("soft"), paint("grid")
    out = [f'<g style="fill:{soft}">']
    for at, text in zip(*_ticks(y, round(panel.height / 36)), strict=True):
        out.append(f'<path class="grid" style="stroke:{grid}" d="M{LEFT:g} {at:.1f}H{x.end}"/>')
        out.append(f'<text x="{LEFT - 6}" y="{at + 4:.1f}" text-anchor="end">{text}</text>')
    for at, text in zip(*_ticks(x, 10, panel.x_names), strict=True):
        out.append(f'<path class="grid" style="stroke:{grid}" d="M{at:.1f} {TOP:g}V{bottom}"/>')
        out += [
            f'<text x="{at:.1f}" y="{bottom + 15 + NAME * row}" text-anchor="middle">'
            f"{escape(line)}</text>"
            for row, line in enumerate(text.split("\n") if labelled else ())
        ]
    if labelled:
        middle = (LEFT + x.end) / 2
        label = escape(panel.x_label)
        out.append(f'<text x="{middle}" y="{bottom + 30}" text-anchor="middle">{label}</text>')
    out.append("</g>")
    box = f'x="{LEFT:g}" y="{TOP:g}" width="{x.end - LEFT:g}" height="{panel.height:g}"'
    view = f"{LEFT:g} {TOP:g} {x.end - LEFT:g} {panel.height:g}"
    out.append(f'<svg {box} viewBox="{view}">{_contents(panel, x, y)}')
    if panel.of_time:
        out += [_event(float(x.at(np.array(at))), number) for at, number in events]
    return "".join([*out, "</svg>"])


def panel_height(panel: Panel, *, labelled: bool) -> float:
    """Return the height of a panel with its axis."""
    rows = max((name.count("\n") for name in panel.x_names), default=0)
    return TOP + panel.height + (BOTTOM + NAME * rows if labelled else 4.0)


def _contents(panel: Panel, x: Axis, y: Axis) -> str:
    out = []
    for band in panel.bands:
        start, end = x.at(np.array(band.span))
        out.append(
            f'<rect class="band" x="{start:.1f}" y="{y.end:g}" height="{y.start - y.end:g}" '
            f'width="{max(1.0, end - start):.1f}" style="fill:{paint(band.tint)}" opacity=".18">'
            f"<title>{escape(band.label)}</title></rect>"
        )
    out += [_layer(layer, x, y) for layer in panel.layers]
    if panel.with_zero:
        zero = float(y.at(np.array(0.0)))
        out.append(_level(zero, x, f"stroke:{paint('object')};stroke-width:.9"))
    for level in panel.levels:
        style = f"stroke:{paint(level.tint)};stroke-dasharray:2 3"
        out.append(_level(float(y.at(np.array(level.y))), x, style))
    out += [_line(line, x, y) for line in panel.lines]
    out += [_dots(dots, x, y) for dots in panel.dots]
    return "".join(out + [_note(note, x, y) for note in panel.notes])


def _line(line: Line, x: Axis, y: Axis) -> str:
    across, up = x.at(line.x), y.at(line.y)
    if x.log:
        parts = reduced(across, up, period=0.0, column=0.0)
    else:
        parts = reduced(across, up, period=line.period / x.per_unit, column=1.0)
    paths = "".join(_path(across[rows], up[rows]) for rows in parts)
    dash = f";stroke-dasharray:{' '.join(map(str, line.dash))}" if line.dash else ""
    style = f"stroke:{paint(line.tint)};stroke-width:{line.width:g}{dash}"
    return f'<path class="line" style="{style}" d="{paths}"/>'


def _path(across: Array, up: Array) -> str:
    if len(across) == 1:
        return f"M{across[0]:.1f} {up[0]:.1f}h.6"
    pairs = [f"{a:.1f} {b:.1f}" for a, b in zip(across.tolist(), up.tolist(), strict=True)]
    return "M" + "L".join(pairs)


def _dots(dots: Dots, x: Axis, y: Axis) -> str:
    points = np.column_stack([x.at(dots.x), y.at(dots.y)])
    grid = {"dot": 1.5, "ring": 0.1}.get(dots.mark, 4.5)
    kept = np.unique(np.round(points[np.isfinite(points).all(axis=1)] / grid), axis=0) * grid
    mark = MARKS[dots.mark]
    path = "".join(f"M{a:.1f} {b:.1f}{mark}" for a, b in kept.tolist())
    return f'<path class="dots {dots.mark}" style="stroke:{paint(dots.tint)}" d="{path}"/>'


def _layer(layer: Layer, x: Axis, y: Axis) -> str:
    parts = reduced(x.at(layer.x), y.at(layer.high), period=0.0, column=1.0)
    rows = np.concatenate([np.zeros(0, dtype=np.int64), *parts])
    if not len(rows):
        return ""
    across = np.concatenate([x.at(layer.x[rows]), x.at(layer.x[rows])[::-1]])
    up = np.concatenate([y.at(layer.high[rows]), y.at(layer.low[rows])[::-1]])
    path = _path(across, up) + "Z"
    hatch = f'<path style="fill:url(#hatch{layer.hatch})" d="{path}"/>' if layer.hatch else ""
    style = f"fill:{paint(layer.tint)};stroke:{paint('paper')};stroke-width:.6"
    return f'<path class="layer" style="{style}" opacity=".8" d="{path}"/>{hatch}'


def _level(up: float, x: Axis, style: str) -> str:
    return f'<path class="line" style="{style}" d="M{x.start:g} {up:.1f}H{x.end:g}"/>'


def _note(note: Note, x: Axis, y: Axis) -> str:
    across, up = float(x.at(np.array(note.x))), float(y.at(np.array(note.y)))
    anchor = "end" if across > (x.start + x.end) / 2 else "start"
    shift = -6 if anchor == "end" else 6
    return (
        f'<text class="note" x="{across + shift:.1f}" y="{up - 5:.1f}" text-anchor="{anchor}" '
        f'style="fill:{paint("alarm")};font-weight:700">{escape(note.text)}</text>'
    )


def _event(across: float, number: str) -> str:
    style = f"stroke:{paint('soft')};stroke-dasharray:1 4"
    return (
        f'<path class="ev" style="{style}" d="M{across:.1f} 0V9999"/>'
        f'<text class="ev" x="{across + 3:.1f}" y="{TOP + 10}" style="fill:{paint("soft")};'
        f'font-size:10px">{escape(number)}</text>'
    )


def _ticks(axis: Axis, wanted: int, names: Sequence[str] = ()) -> tuple[list[float], list[str]]:
    found = list(enumerate(names)) or axis.ticks(wanted)
    values = axis.at(np.array([value for value, _ in found], dtype=float))
    return values.tolist(), [text for _, text in found]


def hatches() -> str:
    """Return the patterns that areas refer to."""
    return "".join(
        f'<pattern id="hatch{index}" width="8" height="8" patternUnits="userSpaceOnUse">'
        f'<path d="{path}" style="stroke:{paint("paper")};fill:none" stroke-width="1.2" '
        'opacity=".5"/></pattern>'
        for index, path in enumerate(HATCHES)
        if path
    )


def sample(each: Line | Dots | Layer) -> str:
    """Return the mark of a legend, 26 by 12."""
    if isinstance(each, Layer):
        box = f'<rect width="26" height="12" style="fill:{paint(each.tint)}" opacity=".8"/>'
        hatch = f'<rect width="26" height="12" style="fill:url(#hatch{each.hatch})"/>'
        return box + (hatch if each.hatch else "")
    if isinstance(each, Dots):
        path = f"M13 6{MARKS[each.mark]}"
        return f'<path class="dots {each.mark}" style="stroke:{paint(each.tint)}" d="{path}"/>'
    dash = f";stroke-dasharray:{' '.join(map(str, each.dash))}" if each.dash else ""
    style = f"stroke:{paint(each.tint)};stroke-width:{each.width:g}{dash}"
    return f'<path class="sample" style="{style}" d="M0 6H26"/>'


def entries(panel: Panel) -> list[Line | Dots | Layer]:
    """Return what a legend names: every label once."""
    drawn: list[Line | Dots | Layer] = [*panel.lines, *panel.dots, *panel.layers]
    found: dict[str, Line | Dots | Layer] = {}
    for each in drawn:
        found.setdefault(each.label, each)
    return list(found.values())
