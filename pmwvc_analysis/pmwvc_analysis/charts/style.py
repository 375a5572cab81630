# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The look of figures: colours for colour-blind readers on light and dark, and for matplotlib a
title and a line of parameters.

Users differ by colour, the signals of a user by line style: never by colour alone.
"""

import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LIGHT_USERS = (
    "#1768B6", "#B15300", "#34B173", "#A15C85", "#5BAEE0", "#F19000", "#520E5F", "#4F2D00",
)  # fmt: skip
DARK_USERS = (
    "#14A0FB", "#F07D02", "#7BDD95", "#C18A9E", "#6DCFFF", "#FFE770", "#9B64A5", "#9C6F36",
)  # fmt: skip
TINTS = {  # on light, on dark paper
    **{f"u{index}": pair for index, pair in enumerate(zip(LIGHT_USERS, DARK_USERS, strict=True))},
    "object": ("#222222", "#E8EAED"),
    "target": ("#7F7F7F", "#9AA3AD"),
    "hand": ("#A9ADB2", "#717A84"),
    "alarm": ("#B00020", "#FF6B7A"),
    "paper": ("#FFFFFF", "#14171B"),
    "ink": ("#1C1F23", "#E6E8EB"),
    "soft": ("#5B636D", "#A3ABB4"),
    "grid": ("#E3E6EA", "#2B3138"),
}
LIGHT, DARK = ({name: pair[paper] for name, pair in TINTS.items()} for paper in (0, 1))


def user_tint(index: int) -> str:
    """Return the name of a user's colour."""
    return f"u{index % len(LIGHT_USERS)}"


def css_variables(colours: Mapping[str, str]) -> str:
    """Return the colours as CSS custom properties ``--c-NAME``."""
    return " ".join(f"--c-{name}: {tint};" for name, tint in colours.items())


WIDTH_IN, ROW_IN = 10.0, 2.4  # of a figure; of a panel of 180 px
LABEL_LETTERS = 30  # in a line of a legend
DPI = 110
SETTINGS: dict[str, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 10.0,
    "axes.titlesize": 11.0,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#E3E3E3",
    "grid.linewidth": 0.8,
    "axes.axisbelow": True,
    "lines.linewidth": 1.5,
    "legend.frameon": False,
    "legend.fontsize": 9.0,
    "path.simplify": True,
    "agg.path.chunksize": 20000,
    "svg.fonttype": "none",  # text stays text
    "svg.hashsalt": "pmwvc",  # the same picture is the same file
}


def canvas(heights: Sequence[float], *, title: str, note: str) -> tuple["Figure", "list[Axes]"]:
    """Return a figure and its rows of axes, titled and noted; ``heights`` of the rows in px."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    tall = ROW_IN * sum(heights) / 180.0
    figure = Figure(figsize=(WIDTH_IN, 1.1 + tall), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    ratios: Any = {"height_ratios": list(heights)}
    axes = figure.subplots(len(heights), 1, squeeze=False, gridspec_kw=ratios)
    figure.suptitle(title, x=0.01, ha="left", fontsize=13, fontweight="bold")
    figure.supxlabel(note, x=0.01, ha="left", fontsize=8, color="#555555")
    return figure, list(axes[:, 0])


def save(
    figure: "Figure", folder: Path, name: str, kinds: Sequence[str] = ("png", "svg")
) -> list[Path]:
    """Write a figure on white as ``NAME.png`` and ``NAME.svg``; return both."""
    folder.mkdir(parents=True, exist_ok=True)
    if (layout := figure.get_layout_engine()) is not None:  # once for both files
        layout.execute(figure)
        figure.set_layout_engine(None)
    paths = [folder / f"{name}.{kind}" for kind in kinds]
    for path in paths:
        figure.savefig(path, dpi=DPI, facecolor="white", metadata={"Date": None})
    return paths


def legend(axes: "Axes") -> None:
    """Put the legend right of the axes, each label once; long ones are wrapped, to leave room."""
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        once = dict(zip(reversed(labels), reversed(handles), strict=True))
        texts = {label: textwrap.fill(label, LABEL_LETTERS) for label in dict.fromkeys(labels)}
        place: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (1.005, 1.02)}
        axes.legend([once[e] for e in texts], texts.values(), borderaxespad=0.0, **place)
