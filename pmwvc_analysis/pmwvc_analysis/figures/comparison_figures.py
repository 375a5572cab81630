# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Figures of a comparison: the same signals of all sessions in panels side by side, one scale for
all, and the measures as dots. Along the axis of the task.

Panels share the scale of the stable sessions, so that one that diverges does not flatten the
others; what leaves the panel is said in its title.
"""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np

from pmwvc_analysis.charts import style
from pmwvc_analysis.compare.measures import Entry
from pmwvc_analysis.figures import comparison_admittance, recorded
from pmwvc_analysis.figures.figures import Picture
from pmwvc_analysis.traces.reductions import position_error
from pmwvc_core.numeric import Array
from pmwvc_core.traces import SessionTraces

COLUMNS = 3
PANEL_IN = (4.4, 2.5)
BARS = (  # measure, label, factor
    ("coherency_rms_m", "device from avatar,\nRMS [mm]", 1e3),
    ("force_error_rms_n", "force error,\nRMS [N]", 1.0),
    ("force_noise_n", "force noise,\nRMS [mN]", 1e3),
    ("energy_min_j", "lowest energy\nbalance [mJ]", 1e3),
)
Draw = Callable[[Any, Entry], list[Array]]


def draw_all(entries: Sequence[Entry], folder: Path) -> list[Picture]:
    """Write every figure as PNG and SVG, and return the PNGs in reading order."""
    import matplotlib

    pictures = []
    with matplotlib.rc_context(style.SETTINGS):
        for name, (draw, unit, heading, caption) in PANELS.items():
            figure = panels(entries, draw, unit=unit, title=heading)
            pictures.append(_saved(figure, folder, f"compare_{name}", heading, caption))
        if len(entries) == 2:
            heading = "Two sessions overlaid"
            caption = "Each user's force and position: the first session solid, the second dashed."
            picture = _saved(overlay(*entries), folder, "compare_overlay", heading, caption)
            pictures.insert(0, picture)
        figure = comparison_admittance.draw(entries)
        if figure is not None:
            heading = "Rendered to the first user"
            caption = (
                "Motion of the device per force of the hand; low is stiff, a peak is a resonance."
            )
            pictures.append(_saved(figure, folder, "compare_admittance", heading, caption))
        figure = dots(entries)
        heading, caption = "Measures", "One row of dots per measure, one column per session."
        pictures.insert(0, _saved(figure, folder, "compare_measures", heading, caption))
    return pictures


def _saved(figure: Any, folder: Path, name: str, heading: str, caption: str) -> Picture:
    path = style.save(figure, folder / f"{name}.png")
    figure.savefig(folder / f"{name}.svg", facecolor="white")
    return Picture(name, path, heading, caption)


def panels(entries: Sequence[Entry], draw: Draw, *, unit: str, title: str) -> Any:
    """Draw one panel per session."""
    columns = min(COLUMNS, len(entries)) if len(entries) != 4 else 2
    rows = -(-len(entries) // columns)
    figure, grid = _canvas(rows, columns, title)
    places = grid.ravel()
    drawn = [draw(axes, entry) for axes, entry in zip(places, entries, strict=False)]
    low, high = _common_range(entries, drawn)
    for place, (axes, entry, signals) in enumerate(zip(places, entries, drawn, strict=False)):
        beyond = any(np.nanmax(s) > high or np.nanmin(s) < low for s in signals if len(s))
        verdict = "stable" if entry.measures["stable"] else None
        verdict = verdict or entry.measures["instability"] or "not judged"
        note = f"{verdict}; leaves the panel" if beyond else verdict
        tint = style.OBJECT if entry.measures["stable"] else style.ALARM
        axes.set_title(f"{entry.label}\n{note}", fontsize=9.5, color=tint)
        axes.set_ylim(low, high)
        if place % columns == 0:
            axes.set_ylabel(unit)
        if place >= len(entries) - columns:
            axes.set_xlabel("time [s]")
    for axes in places[len(entries) :]:
        axes.set_visible(False)
    handles, labels = places[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower left", ncols=6)
    return figure


def _canvas(
    rows: int, columns: int, title: str, *, share_y: Literal["all", "row"] = "all"
) -> tuple[Any, Any]:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    size = (PANEL_IN[0] * columns, 1.1 + PANEL_IN[1] * rows)
    figure = Figure(figsize=size, dpi=style.DPI, layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.subplots(rows, columns, sharex=True, sharey=share_y, squeeze=False)
    figure.suptitle(title, x=0.01, ha="left", fontsize=13, fontweight="bold")
    return figure, grid


def _common_range(entries: Sequence[Entry], drawn: list[list[Array]]) -> tuple[float, float]:
    """Return the limits that hold every signal of the stable sessions (of all if none is)."""
    chosen = [s for e, signals in zip(entries, drawn, strict=True) for s in signals
              if e.measures["stable"]]  # fmt: skip
    chosen = chosen or [s for signals in drawn for s in signals]
    values = np.concatenate([s[np.isfinite(s)] for s in chosen] or [np.zeros(1)])
    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 0.0)
    margin = 0.06 * (high - low) or 1.0
    return low - margin, high + margin


def _colours(traces: SessionTraces) -> dict[str, str]:
    return {name: style.colour(place) for place, name in enumerate(recorded.names(traces))}


def _shown(entry: Entry) -> np.typing.NDArray[np.bool_]:
    """Tell which steps of the server to show: it runs on a little after the users have left."""
    server, users = entry.traces.server, entry.traces.users
    if server is None:
        return np.zeros(0, dtype=np.bool_)
    end_s = min((float(user.time_s[-1]) for user in users), default=float(server.time_s[-1]))
    return np.asarray(server.time_s <= end_s)


def _positions(axes: Any, entry: Entry) -> list[Array]:
    traces, found = entry.traces, []
    server, colours = traces.server, _colours(traces)
    if server is not None:
        shown = _shown(entry)
        target = np.where(shown, server.target[:, 0], np.nan) * 1e3
        found += [target, np.where(shown, server.x_o[:, 0], np.nan) * 1e3]
        axes.plot(server.time_s, found[0], color=style.TARGET, ls=(0, (1, 1.2)), label="target")
        axes.plot(server.time_s, found[1], color=style.OBJECT, lw=1.8, label="object")
    for user in traces.users:
        found.append(user.x_m[:, 0] * 1e3)
        label = f"{user.name} device"
        axes.plot(user.time_s, found[-1], color=colours[user.name], lw=1.2, label=label)
    if server is not None:
        for place, name in enumerate(server.users):
            there = shown & (server.state[place] > 0)
            avatar = np.where(there, server.x_s[place][:, 0], np.nan) * 1e3
            label = f"{name} avatar"
            axes.plot(server.time_s, avatar, color=colours[name], ls="--", lw=1.0, label=label)
    return found


def _forces(axes: Any, entry: Entry) -> list[Array]:
    traces, found = entry.traces, []
    server, colours = traces.server, _colours(traces)
    for user in traces.users:
        found.append(user.f_applied[:, 0])
        label = f"{user.name} device on hand"
        axes.plot(user.time_s, found[-1], color=colours[user.name], lw=1.2, label=label)
    if server is not None:
        for place, name in enumerate(server.users):
            there = _shown(entry) & (server.state[place] > 0)
            contact = np.where(there, server.f_s[place][:, 0], np.nan)
            label = f"{name} contact on avatar"
            axes.plot(server.time_s, contact, color=colours[name], ls="--", lw=0.9, label=label)
    return found


def _separations(axes: Any, entry: Entry) -> list[Array]:
    server, colours, found = entry.traces.server, _colours(entry.traces), []
    for user in entry.traces.users:
        if server is None or user.name not in server.users:
            continue
        apart = position_error(user, server, server.users.index(user.name))
        if apart is not None:
            found.append(apart[1][:, 0] * 1e3)
            axes.plot(apart[0], found[-1], color=colours[user.name], lw=1.2, label=user.name)
    return found


def overlay(first: Entry, second: Entry) -> Any:
    """Draw the same signals of two sessions into the same axes, one column per user."""
    names = [user.name for user in first.traces.users]
    figure, grid = _canvas(2, len(names), f"{first.label} and {second.label}", share_y="row")
    colours = _colours(first.traces)
    for entry, dashes, width in ((first, "-", 2.2), (second, "--", 1.3)):
        for column, name in enumerate(names):
            user = next(user for user in entry.traces.users if user.name == name)
            tint = colours[name] if entry is first else style.OBJECT
            options = {"color": tint, "ls": dashes, "lw": width, "label": entry.label}
            grid[0, column].plot(user.time_s, user.f_applied[:, 0], **options)
            grid[1, column].plot(user.time_s, user.x_m[:, 0] * 1e3, **options)
            grid[0, column].set_title(name, color=colours[name], fontweight="bold")
            grid[1, column].set_xlabel("time [s]")
    grid[0, 0].set_ylabel("device on hand [N]")
    grid[1, 0].set_ylabel("device [mm]")
    for axes in grid[0]:
        axes.legend(loc="best")
    return figure


def dots(entries: Sequence[Entry]) -> Any:
    """Draw the measures of all sessions, those that were not stable as crosses."""
    labels = [entry.label.replace(", ", "\n") for entry in entries]
    width = max(6.0, 2.2 + 1.6 * len(entries))
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, 1.8 + 1.25 * len(BARS)), dpi=style.DPI, layout="constrained")
    FigureCanvasAgg(figure)
    rows = figure.subplots(len(BARS), 1, sharex=True)
    figure.suptitle("Measures", x=0.01, ha="left", fontsize=13, fontweight="bold")
    for axes, (name, label, factor) in zip(rows, BARS, strict=True):
        known = [v * factor for e in entries if (v := e.measures[name]) is not None]
        for place, entry in enumerate(entries):
            value = entry.measures[name]
            if value is None:
                continue
            stable = entry.measures["stable"]
            tint = style.colour(0) if stable else style.ALARM
            axes.plot(place, value * factor, marker="o" if stable else "X", ms=8, color=tint)
        if known and min(known) > 0.0 and max(known) > 30.0 * min(known):
            axes.set_yscale("log")
        elif known and min(known) >= 0.0 and max(known) > 0.0:
            axes.set_ylim(-0.08 * max(known), 1.2 * max(known))
        axes.set_ylabel(label, rotation=0, ha="right", va="center")
        axes.set_xlim(-0.5, len(entries) - 0.5)
    rows[-1].set_xticks(range(len(entries)), labels, fontsize=8.5)
    figure.align_ylabels(rows)
    return figure


PANELS: dict[str, tuple[Draw, str, str, str]] = {
    "positions": (
        _positions,
        "position [mm]",
        "Positions",
        "Solid: devices. Dashed: their avatars. Black: the object; dotted: its target.",
    ),
    "forces": (
        _forces,
        "force [N]",
        "Forces",
        "Solid: what the device exerts on the hand. Dashed: the contact force on the avatar.",
    ),
    "separations": (
        _separations,
        "x_m - x_s [mm]",
        "Device from avatar",
        "Distance of each device from its avatar, less the distance at joining.",
    ),
}
