# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""How all figures look: colours for colour-blind readers, a title, a line of parameters.

Users differ by colour, what is drawn of a user by line style: never by colour alone.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np

from pmwvc_analysis.figures.colours import LIGHT, LIGHT_USERS
from pmwvc_analysis.report.text import users
from pmwvc_core.controllers import has_waves
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces

Share = Literal["none", "col"]
USERS = LIGHT_USERS
OBJECT = LIGHT["object"]
TARGET = LIGHT["target"]
ALARM = LIGHT["alarm"]
WIDTH_IN = 10.0
DPI = 110
AXES = ("x", "y", "z", "axis 4", "axis 5", "axis 6")
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
}


def colour(place: int) -> str:
    """Return a user's colour."""
    return USERS[place % len(USERS)]


def colours(traces: SessionTraces) -> dict[str, str]:
    """Return the colour of every user by name."""
    names = list(traces.server.users) if traces.server else []
    names += [user.name for user in traces.users if user.name not in names]
    return {name: colour(place) for place, name in enumerate(names)}


def canvas(
    rows: int,
    *,
    title: str,
    note: str,
    row_in: float = 2.4,
    share: Share = "col",
    heights: Sequence[float] | None = None,
) -> tuple[Any, list[Any]]:
    """Return a figure and its rows of axes, titled and noted; ``heights`` of the rows in px."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    tall = sum(row_in * each / 180.0 for each in heights) if heights else row_in * rows
    figure = Figure(figsize=(WIDTH_IN, 1.1 + tall), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    ratios = {"height_ratios": heights} if heights else {}
    axes: Any = figure.subplots(rows, 1, sharex=share, squeeze=False, gridspec_kw=ratios)
    figure.suptitle(title, x=0.01, ha="left", fontsize=13, fontweight="bold")
    figure.supxlabel(note, x=0.01, ha="left", fontsize=8, color="#555555")
    return figure, list(axes[:, 0])


def save(figure: Any, path: Path) -> Path:
    """Write a figure as PNG."""
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=DPI, facecolor="white")
    return path


def legend(axes: Any) -> None:
    """Put the legend to the right of the axes, where it hides nothing."""
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        axes.legend(
            handles, labels, loc="upper left", bbox_to_anchor=(1.005, 1.02), borderaxespad=0.0
        )


def spans(
    flags: np.typing.NDArray[np.bool_], time_s: Array, *, join_s: float
) -> list[tuple[float, float]]:
    """Return the stretches of time with a flag set; those closer than ``join_s`` are one."""
    rows = np.flatnonzero(flags)
    if not len(rows):
        return []
    breaks = np.flatnonzero(np.diff(time_s[rows]) > join_s) + 1
    return [(float(time_s[part[0]]), float(time_s[part[-1]])) for part in np.split(rows, breaks)]


def title(what: str, scenario: Scenario | None) -> str:
    """Return a figure's title: what it shows, and the scenario."""
    return f"{what} · {scenario.name}" if scenario else what


def note(traces: SessionTraces, scenario: Scenario | None) -> str:
    """Return the line of parameters below a figure, of the first user where users differ."""
    if scenario is None:
        return f"{traces.source}, {traces.duration_s:.1f} s, parameters not known"
    user = scenario.users[0]
    parts = [traces.source, users(len(scenario.users)), f"controller {scenario.controller}"]
    if has_waves(scenario.controller):
        master = user.master
        kind = master.filter.kind.replace("_", " ")
        parts += [
            f"b = {user.impedance:.4g} N s/m",
            f"M = {master.rate_drop}",
            f"filter {kind}",
            f"hold {master.hold}",
        ]
        parts.append(f"coupling {scenario.server.coupling.replace('_', ' ')}")
    contact = user.contact
    parts += [f"K = {contact.contact_stiffness:g} N/m", f"B = {contact.contact_damping:g} N s/m"]
    ways = [f"{u.link_up.delay_s * 1e3:g}/{u.link_down.delay_s * 1e3:g}" for u in scenario.users]
    parts += [f"delay {', '.join(dict.fromkeys(ways))} ms", f"seed {scenario.seed}"]
    return " · ".join(parts)
