# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Results on disk: one JSON and one SVG per figure.

Text stays text. Of a line with very many points the picture keeps the lowest and the highest of
each short stretch, so its envelope, which keeps the file small; the JSON holds every point.
"""

import io
import json
import re
from pathlib import Path
from typing import Any

import numpy as np

from pmwvc_analysis.charts import style
from pmwvc_core.numeric import Array
from reproduction.figure import Figure, Values

STRETCHES = 400  # of a dense line, two points each
LONG_NUMBER = re.compile(r"(\d+\.\d\d)\d+")
SETTINGS = {"svg.fonttype": "none", "svg.hashsalt": "reproduction", "path.simplify": True}


def write(figure: Figure, result: Values, folder: Path) -> None:
    """Write ``NAME.json`` and ``NAME.svg``."""
    import matplotlib as mpl

    text = json.dumps(result, ensure_ascii=False, separators=(",", ":"))
    (folder / f"{figure.name}.json").write_text(text + "\n", encoding="utf-8")
    with mpl.rc_context({**style.SETTINGS, **SETTINGS}):
        _picture(figure.draw(result), folder / f"{figure.name}.svg")


def _picture(drawn: Any, path: Path) -> None:
    for axes in drawn.axes:
        for line in axes.get_lines():
            line.set_data(*envelope(*(np.asarray(v, dtype=float) for v in line.get_data())))
    text = io.StringIO()
    drawn.savefig(text, format="svg", facecolor="white", metadata={"Date": None})
    path.write_text(LONG_NUMBER.sub(r"\1", text.getvalue()), encoding="utf-8")


def envelope(x: Array, y: Array) -> tuple[Array, Array]:
    """Return a line with the lowest and the highest point of each stretch, in order; one with few
    points as it is.
    """
    if len(x) <= 4 * STRETCHES:
        return x, y
    kept = []
    for rows in np.array_split(np.arange(len(x)), STRETCHES):
        known = rows[np.isfinite(y[rows])]
        ends = (known[np.argmin(y[known])], known[np.argmax(y[known])]) if len(known) else rows[:1]
        kept += sorted({*ends})
    return x[kept], y[kept]


def read(name: str, folder: Path) -> Values:
    """Return a committed result."""
    found: Values = json.loads((folder / f"{name}.json").read_text(encoding="utf-8"))
    return found
