# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Figures of motion and force.

The server runs on for a moment after the masters have ended; its curves end where the users' do.
"""

import itertools

import numpy as np

from pmwvc_analysis.charts.chart import DASHES, Chart, Curve, Dash, Level, Panel
from pmwvc_analysis.figures import recorded
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces, UserTraces

AXES = ("x", "y", "z", "axis 4", "axis 5", "axis 6")
TOGETHER = 2  # users in one panel; more have a panel each
MOST_PANELS = 18
NEAR_LIMIT = 0.7


def positions(traces: SessionTraces, scenario: Scenario | None) -> Chart | None:
    """Return devices, avatars, object and target: a panel per axis, of many users per user."""
    server, names = traces.server, recorded.names(traces)
    if server is None and not traces.users:
        return None
    dof = server.x_o.shape[-1] if server is not None else traces.users[0].x_m.shape[-1]
    apart = len(names) > TOGETHER and dof * len(names) <= MOST_PANELS
    panels = [
        Panel(
            "position [mm]" if dof == 1 else f"{AXES[axis]} [mm]",
            lines=position_lines(traces, axis, group),
            bands=recorded.bands(traces),
            title=group[0] if apart else "",
            tint=recorded.tint(traces, group[0]) if apart else "ink",
            height=150.0 if dof > 1 or apart else 300.0,
        )
        for group in ([[name] for name in names] if apart else [names])
        for axis in range(dof)
    ]
    return Chart(
        "positions",
        "Positions",
        "Each user's device and its avatar at the server, the object and its target. "
        "A device ahead of its avatar shows the compliance of the link.",
        panels,
    )


def position_lines(traces: SessionTraces, axis: int, group: list[str]) -> list[Curve]:
    """Return target, object and, for the users of a group, device and avatar along an axis."""
    server, lines, avatars = traces.server, [], []
    if server is not None:
        lines.append(_of_server(traces, "target", server.target[:, axis] * 1e3, "target", (), 4.0))
        lines.append(_of_server(traces, "object", server.x_o[:, axis] * 1e3, "object", (), 2.8))
    users = {user.name: user for user in traces.users}
    for order, name in enumerate(group):
        tint = recorded.tint(traces, name)
        if (user := users.get(name)) is not None:
            dash = DASHES[(0, 6)[order]] if len(group) <= TOGETHER else DASHES[order % len(DASHES)]
            look = tint, dash, 1.8 - 0.1 * order, user.tick_s
            x_m = user.x_m[:, axis]
            lines.append(Curve(f"{name} device", user.time_s, x_m * 1e3, *look))
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
    return Curve(label, server.time_s[rows], values[rows], tint, dash, width, server.period_s)


def forces(traces: SessionTraces, scenario: Scenario | None) -> Chart | None:
    """Return the forces at hand, device and avatar: a panel per user and axis."""
    if not traces.users:
        return None
    limits = {user.name: user.safety.max_force for user in scenario.users} if scenario else {}
    dof = traces.users[0].f_applied.shape[1]
    axes = range(dof) if dof * len(traces.users) <= MOST_PANELS else range(1)
    panels = []
    for user, axis in itertools.product(traces.users, axes):
        lines, limit = force_lines(traces, user, axis), float(limits.get(user.name, np.inf))
        seen = np.concatenate([line.y for line in lines])
        near = (-limit, -np.nanmin(seen, initial=0.0)), (limit, np.nanmax(seen, initial=0.0))
        panels.append(
            Panel(
                "force [N]" if dof == 1 else f"force, {AXES[axis]} [N]",
                lines=lines,
                bands=recorded.bands(traces),
                levels=[Level("force limit", edge) for edge, n in near if n > NEAR_LIMIT * limit],
                title=user.name if axis == 0 else "",
                tint=recorded.tint(traces, user.name),
                height=170.0 if axis == 0 else 110.0,
            )
        )
    return Chart(
        "forces",
        "Forces",
        "Force of the hand on the device, force that the device renders, and contact force on the "
        "avatar. In a steady grip all three are equal.",
        panels,
    )


def force_lines(traces: SessionTraces, user: UserTraces, axis: int) -> list[Curve]:
    """Return the forces at hand, device and avatar of a user along an axis."""
    lines, server = [], traces.server
    f_h, f_m, tint = user.f_h[:, axis], user.f_applied[:, axis], recorded.tint(traces, user.name)
    if np.isfinite(f_h).any():
        lines.append(Curve("hand on device", user.time_s, f_h, "hand", (), 4.0, user.tick_s))
    lines.append(Curve("rendered by the device", user.time_s, f_m, tint, (), 1.8, user.tick_s))
    if server is not None and user.name in server.users:
        f_s = server.f_s[server.users.index(user.name)][:, axis]
        lines.append(_of_server(traces, "contact on avatar", f_s, "object", (6, 4), 1.2))
    return lines
