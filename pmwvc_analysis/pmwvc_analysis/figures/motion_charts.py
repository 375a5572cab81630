# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Figures of motion and force.

The server runs on for a moment after the masters have ended; its curves end where the users' do.
"""

import itertools
from typing import Any

import numpy as np

from pmwvc_analysis.charts.chart import DASHES, Chart, Curve, Dash, Level, Panel
from pmwvc_analysis.figures import recorded
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces, UserTraces, load_of

AXES = ("x", "y", "z", "about x", "about y", "about z")
TOGETHER = 2  # users in one panel; more have a panel each
MOST_PANELS = 18
NEAR_LIMIT = 0.7
DIGITS = 6  # of mm and N: rounding of an axis that nothing uses is not drawn


def positions(traces: SessionTraces, scenario: Scenario | None) -> Chart | None:
    """Return devices, avatars, object and target: a panel per axis, of many users per user."""
    server, names = traces.server, recorded.names(traces)
    if server is None and not traces.users:
        return None
    dof = server.x_o.shape[-1] if server is not None else traces.users[0].x_m.shape[-1]
    apart = len(names) > TOGETHER and dof * len(names) <= MOST_PANELS
    height, panels = 150.0 if dof > 1 or apart else 300.0, []
    for group, axis in itertools.product([[n] for n in names] if apart else [names], range(dof)):
        label = "position [mm]" if dof == 1 else f"{AXES[axis]} [mm]"
        look: Any = {"title": group[0], "tint": recorded.tint(traces, group[0])} if apart else {}
        lines, bands = position_lines(traces, axis, group), recorded.bands(traces)
        panels.append(Panel(label, lines, bands=bands, height=height, **look))
    return Chart(
        "positions",
        "Positions",
        "Each user's device and its avatar at the server, the object, its target, what else moved "
        "most. A device ahead of its avatar shows the compliance of the link.",
        panels,
    )


def position_lines(traces: SessionTraces, axis: int, group: list[str]) -> list[Curve]:
    """Return target, object and, for the users of a group, device and avatar along an axis."""
    server, lines, avatars = traces.server, [], []
    if server is not None:
        name, others = recorded.bodies(server)
        lines.append(_of_server(traces, "target", server.target[:, axis] * 1e3, "target", (), 4.0))
        lines.append(_of_server(traces, name, server.x_o[:, axis] * 1e3, "object", (), 2.8))
        for n, (body, x) in enumerate(others.items() if axis < 3 else (), 1):  # not how they turn
            lines.append(_of_server(traces, body, x[:, axis] * 1e3, "object", DASHES[n], 2.4))
    users = {user.name: user for user in traces.users}
    for order, name in enumerate(group):
        tint = recorded.tint(traces, name)
        if (user := users.get(name)) is not None:
            dash = DASHES[(0, 6)[order]] if len(group) <= TOGETHER else DASHES[order % len(DASHES)]
            look = tint, dash, 1.8 - 0.1 * order, user.tick_s
            x_m = user.x_m[:, axis]
            lines.append(Curve(f"{name} device", user.time_s, (x_m * 1e3).round(DIGITS), *look))
        if server is not None and name in server.users:
            index, dash = server.users.index(name), (3.0 + 0.5 * order, 3.0 + order)
            x_m = np.where(server.state[index] > 0, server.x_s[index][:, axis], np.nan)
            avatars.append(_of_server(traces, f"{name} avatar", x_m * 1e3, tint, dash, 1.3))
    return lines + avatars


def _of_server(
    traces: SessionTraces, label: str, values: Array, tint: str, dash: Dash, width: float
) -> Curve:
    """Return a signal of the server up to the end of the users."""
    server = traces.server
    assert server is not None
    rows = server.time_s < traces.duration_s
    shown = values[rows].round(DIGITS)
    return Curve(label, server.time_s[rows], shown, tint, dash, width, server.period_s)


def forces(traces: SessionTraces, scenario: Scenario | None) -> Chart | None:
    """Return the forces at hand, device and avatar: a panel per user and axis."""
    if not traces.users:
        return None
    limits = {user.name: user.safety.max_force for user in scenario.users} if scenario else {}
    dof = traces.users[0].f_applied.shape[1]
    axes = range(dof) if dof * len(traces.users) <= MOST_PANELS else range(1)
    panels = []
    for user, axis in itertools.product(traces.users, axes):
        load, unit, scale = load_of(axis, scenario)
        lines, limit = force_lines(traces, user, axis, scale), limits.get(user.name, np.inf)
        seen = np.concatenate([line.y for line in lines] if axis < 3 else [np.zeros(1)])
        near = (-limit, -np.nanmin(seen, initial=0.0)), (limit, np.nanmax(seen, initial=0.0))
        levels = [Level("force limit", edge) for edge, n in near if n > NEAR_LIMIT * limit]
        label = "force [N]" if dof == 1 else f"{load}, {AXES[axis]} [{unit}]"
        title, height = (user.name, 170.0) if axis == 0 else ("", 110.0)
        look: Any = {"title": title, "tint": recorded.tint(traces, user.name), "height": height}
        panels.append(Panel(label, lines, bands=recorded.bands(traces), levels=levels, **look))
    return Chart(
        "forces",
        "Forces",
        "Force of the hand on the device, force that the device renders, and contact force on the "
        "avatar. In a steady grip all three are equal.",
        panels,
    )


def force_lines(traces: SessionTraces, user: UserTraces, axis: int, scale: float) -> list[Curve]:
    """Return the forces at hand, device and avatar of a user along an axis."""
    lines, server = [], traces.server
    f_h, f_m = ((scale * f[:, axis]).round(DIGITS) for f in (user.f_h, user.f_applied))
    tint = recorded.tint(traces, user.name)
    if np.isfinite(f_h).any():
        lines.append(Curve("hand on device", user.time_s, f_h, "hand", (), 4.0, user.tick_s))
    lines.append(Curve("rendered by the device", user.time_s, f_m, tint, (), 1.8, user.tick_s))
    if server is not None and user.name in server.users:
        f_s = scale * server.f_s[server.users.index(user.name)][:, axis]
        lines.append(_of_server(traces, "contact on avatar", f_s, "object", (6, 4), 1.2))
    return lines
