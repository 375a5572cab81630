# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Figures of a comparison: the same signals of all sessions in panels of one scale, along the axis
of the task. The measures stand in its table.

The scale is that of the stable sessions, so that one that diverges does not flatten the others; a
title names where signals leave the panel.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from pmwvc_analysis.charts.chart import Chart, Curve, Panel
from pmwvc_analysis.charts.chart_files import write
from pmwvc_analysis.compare.measures import Compared
from pmwvc_analysis.figures import recorded
from pmwvc_analysis.figures.motion_charts import force_lines, position_lines
from pmwvc_analysis.traces.apart import apart


def draw_all(entries: Sequence[Compared], folder: Path) -> list[tuple[Chart, Path]]:
    """Write every figure as PNG and SVG; return the figures with their PNG in reading order."""
    drawn = []
    for signal in SIGNALS:
        chart = signals(entries, *signal)
        chart = replace(chart, name=f"compare_{chart.name}", title=chart.heading)
        drawn.append((chart, write(chart, folder)[0]))
    return drawn


def signals(
    entries: Sequence[Compared],
    name: str,
    heading: str,
    caption: str,
    y_label: str,
    lines_of: Callable[[Compared], list[Curve]],
) -> Chart:
    """Return a panel per session, of one scale: that of the stable sessions, of all if none is."""
    pairs = [(entry, lines_of(entry)) for entry in entries]
    chosen = [line.y for entry, lines in pairs for line in lines if entry.measures["stable"]]
    chosen = chosen or [line.y for _, lines in pairs for line in lines]
    values = np.concatenate([np.zeros(0), *(y[np.isfinite(y)] for y in chosen)])
    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 0.0)
    margin = 0.06 * (high - low) or 1.0
    look: dict[str, Any] = {"y_range": (low - margin, high + margin), "height": 130.0}
    panels = []
    for entry, lines in pairs:
        below, above = look["y_range"]
        leaves = any(np.nanmax(line.y) > above or np.nanmin(line.y) < below for line in lines)
        stable = entry.measures["stable"]
        verdict = "stable" if stable else entry.measures["instability"] or "not judged"
        look["title"] = f"{entry.label}: {verdict}{'; leaves the panel' if leaves else ''}"
        panels.append(Panel(y_label, lines, tint="alarm" if stable is False else "ink", **look))
    return Chart(name, heading, caption, panels)


def _forces(entry: Compared) -> list[Curve]:
    traces = entry.traces
    return [
        replace(line, label=f"{user.name}, {line.label}", tint=recorded.tint(traces, user.name))
        for user in traces.users
        for line in force_lines(traces, user, 0, 1.0)
        if line.tint != "hand"
    ]


def _position_errors(entry: Compared) -> list[Curve]:
    traces = entry.traces
    return [
        Curve(user.name, away.time_s, away.error[:, 0] * 1e3, recorded.tint(traces, user.name))
        for user in traces.users
        if (away := apart(traces, user)) is not None
    ]


AVATARS = "Devices, their avatars (short dashes), the object (black) and its target (grey)."
RENDERED = "Solid: force of the device on the hand. Dashed: the contact force on the avatar."
APART = "Distance of each device from its avatar, less the distance at joining."


def _positions(entry: Compared) -> list[Curve]:
    return position_lines(entry.traces, 0, recorded.names(entry.traces))


SIGNALS = (
    ("positions", "Positions", AVATARS, "position [mm]", _positions),
    ("forces", "Forces", RENDERED, "force [N]", _forces),
    ("separations", "Device from avatar", APART, "x_m - x_s [mm]", _position_errors),
)
