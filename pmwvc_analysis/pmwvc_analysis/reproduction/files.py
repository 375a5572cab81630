# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Results on disk: one JSON and one PNG per figure."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from pmwvc_analysis.reproduction.figure import Figure, Values
from pmwvc_analysis.show import style

PIXELS_PER_INCH = 90
COLOURS = 64


def write(figure: Figure, result: Values, folder: Path) -> None:
    """Write ``NAME.json`` and ``NAME.png``."""
    import matplotlib as mpl

    text = json.dumps(result, ensure_ascii=False, separators=(",", ":"))
    (folder / f"{figure.name}.json").write_text(text + "\n", encoding="utf-8")
    with mpl.rc_context(style.SETTINGS):
        drawn = figure.draw(result)
        _picture(drawn, folder / f"{figure.name}.png")


def _picture(drawn: Any, path: Path) -> None:
    """Write a figure with few colours: it has few, and the file becomes small."""
    from PIL import Image

    drawn.set_dpi(PIXELS_PER_INCH)
    drawn.canvas.draw()
    image = Image.fromarray(np.asarray(drawn.canvas.buffer_rgba())).convert("RGB")
    image.quantize(COLOURS, dither=Image.Dither.NONE).save(path, optimize=True)


def read(name: str, folder: Path) -> Values:
    """Return a committed result."""
    found: Values = json.loads((folder / f"{name}.json").read_text(encoding="utf-8"))
    return found
