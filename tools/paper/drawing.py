# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The look of the paper's figures, and where they go."""

from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("svg")
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pmwvc_analysis.charts.style import LIGHT_USERS, SETTINGS

ROOT = Path(__file__).resolve().parents[2]
IMAGES = ROOT / "docs" / "images"
Rows = list[list[str]]  # of a table, the first its heads
WIDTH_IN = 7.2
COLOURS = LIGHT_USERS
MARKS = ("o", "s", "^", "D", "v", "P", "X", "*")  # never by colour alone


def panels(rows: int, columns: int, height_in: float, **options: Any) -> tuple[Figure, list[Axes]]:
    """Return a figure and its axes, row by row."""
    mpl.rcParams.update(SETTINGS | {"font.size": 8.5, "legend.fontsize": 7.5})
    mpl.rcParams.update({"axes.titlesize": 9.0, "svg.hashsalt": "paper"})
    figure, axes = plt.subplots(
        rows,
        columns,
        figsize=(WIDTH_IN, height_in),
        layout="constrained",
        squeeze=False,
        **options,
    )
    return figure, list(axes.flat)


def save(figure: Figure, name: str, folder: Path = IMAGES) -> None:
    """Write a figure as ``paper_NAME.svg``."""
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / f"paper_{name}.svg", metadata={"Date": None})
    plt.close(figure)
