# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Figures of motion and force.

The server runs on for a moment after the masters have ended; its curves end where the users' do.
"""

import numpy as np

from pmwvc_analysis.charts.chart import DASHES, Chart, Level, Line, Panel
from pmwvc_analysis.figures import recorded
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import ServerTraces, SessionTraces, UserTraces

AXES = ("x", "y", "z", "axis 4", "axis 5", "axis 6")
TOGETHER = 2  # users in one panel; more have a panel each
MOST_PANELS = 18
NEAR_LIMIT = 0.7


def positions(traces: SessionTraces, scenario: Scenario | None) -> Chart | None:
    """Return devices, avatars, object and target: a panel per axis, and per user where there are
    more than two.
    """
    server, names = traces.server, recorded.names(traces)
    if server is None and not traces.users:
        return None
    dof = server.x_o.shape[-1] if server is not None else traces.users[0].x_m.shape[-1]
    groups = [names]
    if len(names) > TOGETHER and dof * len(names) <= MOST_PANELS:
        groups = [[name] for name in names]
    panels = []
    for group in groups:
        title = group[0] if len(groups) > 1 else ""
        for axis in range(dof):
            panels.append(
                Panel(
                    "position [mm]" if dof == 1 else f"{AXES[axis]} [mm]",
                    lines=position_lines(traces, axis, group),
                    bands=recorded.bands(traces),
                    title=title,
                    tint=recorded.tint(traces, title) if title else "ink",
                    height=300.0 if dof * len(groups) == 1 else 150.0,
                )
            )
    return Chart(
        "positions",
        "Positions",
        "Each user's device and its avatar at the server, the object and its target. "
        "A device ahead of its avatar shows the compliance of the link.",
        panels,
    )


def position_lines(traces: SessionTraces, axis: int, group: list[str]) -> list[Line]:
    """Return target, object and, for the users of a group, device and avatar along an axis."""
    server, lines = traces.server, []
    if server is not None:
        rows = recorded.until_users_end(traces)
        time_s, period = server.time_s[rows], server.period_s
        lines.append(
            Line("target", time_s, server.target[rows, axis] * 1e3, "target", (), 4.0, period)
        )
        lines.append(
            Line("object", time_s, server.x_o[rows, axis] * 1e3, "object", (), 2.8, period)
        )
    users = {user.name: user for user in traces.users}
    for order, name in enumerate(group):
        tint = recorded.tint(traces, name)
        if name in users:
            user = users[name]
            dash = DASHES[(0, 6)[order]] if len(group) <= TOGETHER else DASHES[order % len(DASHES)]
            x_m = user.x_m[:, axis] * 1e3
            lines.append(
                Line(
                    f"{name} device", user.time_s, x_m, tint, dash, 1.8 - 0.1 * order, user.tick_s
                )
            )
    for order, name in enumerate(group):
        if server is not None and name in server.users:
            lines.append(_avatar(traces, server, name, axis, order))
    return lines


def _avatar(traces: SessionTraces, server: ServerTraces, name: str, axis: int, order: int) -> Line:
    index, rows = server.users.index(name), recorded.until_users_end(traces)
    present = np.where(server.state[index] > 0, server.x_s[index][:, axis], np.nan)[rows]
    tint = recorded.tint(traces, name)
    dash = (3.0 + 0.5 * order, 3.0 + order)
    time_s = server.time_s[rows]
    return Line(f"{name} avatar", time_s, present * 1e3, tint, dash, 1.3, server.period_s)


def forces(traces: SessionTraces, scenario: Scenario | None) -> Chart | None:
    """Return the forces at hand, device and avatar: a panel per user and axis."""
    if not traces.users:
        return None
    limits = {user.name: user.safety.max_force for user in scenario.users} if scenario else {}
    dof = traces.users[0].f_applied.shape[1]
    axes = range(dof) if dof * len(traces.users) <= MOST_PANELS else range(1)
    panels = []
    for user in traces.users:
        for axis in axes:
            lines = force_lines(traces, user, axis)
            along = "force [N]" if dof == 1 else f"force, {AXES[axis]} [N]"
            panels.append(
                Panel(
                    along,
                    lines=lines,
                    bands=recorded.bands(traces),
                    levels=_limits(lines, float(limits.get(user.name, np.inf))),
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


def force_lines(traces: SessionTraces, user: UserTraces, axis: int) -> list[Line]:
    """Return the forces at hand, device and avatar of a user along an axis."""
    lines, server = [], traces.server
    tint = recorded.tint(traces, user.name)
    if np.isfinite(user.f_h[:, axis]).any():
        f_h = user.f_h[:, axis]
        lines.append(Line("hand on device", user.time_s, f_h, "hand", (), 4.0, user.tick_s))
    f_m = user.f_applied[:, axis]
    lines.append(Line("rendered by the device", user.time_s, f_m, tint, (), 1.8, user.tick_s))
    if server is not None and user.name in server.users:
        rows, index = recorded.until_users_end(traces), server.users.index(user.name)
        f_s: Array = server.f_s[index][rows, axis]
        time_s = server.time_s[rows]
        lines.append(
            Line("contact on avatar", time_s, f_s, "object", (6, 4), 1.2, server.period_s)
        )
    return lines


def _limits(lines: list[Line], limit: float) -> list[Level]:
    """Return the force limits that the curves come near."""
    values = np.concatenate([line.y for line in lines])
    low, high = np.nanmin(values, initial=0.0), np.nanmax(values, initial=0.0)
    near = [(-limit, -low), (limit, high)]
    return [Level("force limit", edge) for edge, seen in near if seen > NEAR_LIMIT * limit]
