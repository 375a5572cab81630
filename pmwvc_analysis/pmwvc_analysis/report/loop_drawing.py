# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A drawing of one user's loop as SVG: blocks with their numbers, signals between them."""

from collections.abc import Mapping
from html import escape

from pmwvc_analysis.report.loop_blocks import ALL_USERS, Block
from pmwvc_core.quantities import quantity

WIDTH, HEIGHT = 1180.0, 236.0
UPPER, LOWER = 64.0, 176.0  # heights at which signals run to the server and back
SMALL_J = 5e-9


Box = tuple[float, float, float, float]  # left, top, width, height of a block in the drawing
PLACES: Mapping[str, Box] = {
    "hand": (4, 10, 92, 216),
    "device": (130, 10, 126, 216),
    "port": (290, 10, 132, 216),
    "filter": (456, 10, 138, 100),
    "hold": (456, 126, 138, 100),
    "up": (628, 10, 112, 100),
    "down": (628, 126, 112, 100),
    "decoder": (774, 10, 124, 216),
    "contact": (932, 10, 112, 216),
    "object": (1078, 10, 98, 216),
}
# from, to, at which height, signal; wave signals only where there are waves
FORWARD = (
    ("hand", "device", "f_h"), ("device", "port", "ẋ_m"), ("port", "filter", "u_m"),
    ("filter", "up", ""), ("up", "decoder", "u_s"), ("decoder", "contact", "ẋ_s"),
    ("contact", "object", "F_s"),
)  # fmt: skip
BACK = (
    ("object", "contact", "ẋ_o"), ("contact", "decoder", "F_s"), ("decoder", "down", "v_s"),
    ("down", "hold", ""), ("hold", "port", "v_m"), ("port", "device", "F_m"),
    ("device", "hand", "x_m"),
)  # fmt: skip
WAVES = ("u_m", "u_s", "v_s", "v_m")


def drawing(found: Mapping[str, Block], *, name: str, waves: bool) -> str:
    """Return the drawing of one user's loop."""
    parts = [_box(PLACES[key], block, shared=key in ALL_USERS) for key, block in found.items()]
    for way, height in ((FORWARD, UPPER), (BACK, LOWER)):
        for start, end, signal in way:
            shown = signal if waves or signal not in WAVES else ""
            parts.append(_arrow(PLACES[start], PLACES[end], height, shown))
    return (
        f'<svg class="loop" viewBox="0 0 {WIDTH:g} {HEIGHT:g}" role="img" '
        f'aria-label="Control loop of {escape(name)}">{"".join(parts)}</svg>'
    )


def _box(box: Box, block: Block, *, shared: bool) -> str:
    left, top, width, height = box
    rows = [(escape(block.title), "loop-title")]
    rows += [(escape(line), "") for line in block.lines]
    if block.energy_j is not None:
        energy = 0.0 if abs(block.energy_j) < SMALL_J else block.energy_j
        text = quantity(energy, "J").replace("-", "−")
        gives = block.title == "hand"
        tone = "loop-alarm" if energy < 0.0 and not gives else "loop-energy"
        rows.append((f"{'gives' if gives else 'E ='} {text}", tone))
        if shared:
            rows.append(("of all users", "loop-soft"))
    first = top + height / 2 - 8.5 * (len(rows) - 1) + 4
    texts = "".join(
        f'<text x="{left + width / 2:g}" y="{first + 17 * row:g}" class="{kind}">{text}</text>'
        for row, (text, kind) in enumerate(rows)
    )
    at = f'x="{left:g}" y="{top:g}" width="{width:g}" height="{height:g}"'
    return f'<rect {at} rx="6"/>{texts}'


def _arrow(start: Box, end: Box, height: float, signal: str) -> str:
    left_to_right = start[0] < end[0]
    tail, tip = (start[0] + start[2], end[0]) if left_to_right else (start[0], end[0] + end[2])
    head = -8 if left_to_right else 8
    path = f"M{tail:g} {height:g}H{tip:g}M{tip + head:g} {height - 4:g}L{tip:g} {height:g}"
    path += f"L{tip + head:g} {height + 4:g}"
    label = f'<text x="{(tail + tip) / 2:g}" y="{height - 8:g}" class="loop-soft">{signal}</text>'
    return f'<path d="{path}"/>{label if signal else ""}'
