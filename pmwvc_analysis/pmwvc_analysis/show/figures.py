# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The figures of a session: motion and force; others in ``channel_figures``, ``energy_figures``.

A figure whose signals were not recorded is left out.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pmwvc_analysis.show import style
from pmwvc_analysis.show.channel_figures import energy, loop, network
from pmwvc_analysis.show.energy_figures import bookings, whereabouts
from pmwvc_core.simulation.scenario import Scenario
from pmwvc_core.simulation.traces import SessionTraces

Draw = Callable[[SessionTraces, Scenario | None], Any]


@dataclass(frozen=True)
class Picture:
    """A figure on disk, and how to read it."""

    name: str
    path: Path
    heading: str
    caption: str


def draw_all(traces: SessionTraces, scenario: Scenario | None, folder: Path) -> list[Picture]:
    """Write every figure that the traces allow as PNG, and return them in reading order."""
    import matplotlib

    pictures = []
    with matplotlib.rc_context(style.SETTINGS):
        for name, (draw, heading, caption) in FIGURES.items():
            figure = draw(traces, scenario)
            if figure is not None:
                path = style.save(figure, folder / f"{name}.png")
                pictures.append(Picture(name, path, heading, caption))
    return pictures


def motion(traces: SessionTraces, scenario: Scenario | None) -> Any:
    """Draw positions of devices, avatars, object and target, one row per axis of motion."""
    server, colours = traces.server, style.colours(traces)
    if server is None and not traces.users:
        return None
    dof = server.x_o.shape[-1] if server is not None else traces.users[0].x_m.shape[-1]
    figure, rows = style.canvas(
        dof,
        title=style.title("Positions", scenario),
        note=style.note(traces, scenario),
        row_in=4.2 if dof == 1 else 2.6,
    )
    for axis, axes in enumerate(rows):
        if server is not None:
            axes.plot(
                server.time_s,
                server.target[:, axis] * 1e3,
                color=style.TARGET,
                ls=(0, (1, 1.2)),
                lw=2.2,
                label="target",
            )
            axes.plot(
                server.time_s,
                server.x_o[:, axis] * 1e3,
                color=style.OBJECT,
                lw=2.0,
                label="object",
            )
        for user in traces.users:
            axes.plot(
                user.time_s,
                user.x_m[:, axis] * 1e3,
                color=colours[user.name],
                label=f"{user.name} device",
            )
        if server is None:
            continue
        for place, name in enumerate(server.users):
            avatar = np.where(server.state[place] > 0, server.x_s[place][:, axis], np.nan)
            axes.plot(
                server.time_s, avatar * 1e3, color=colours[name], ls="--", label=f"{name} avatar"
            )
    for axis, axes in enumerate(rows):
        axes.set_ylabel("position [mm]" if dof == 1 else f"{style.AXES[axis]} [mm]")
        style.legend(axes)
    rows[-1].set_xlabel("time [s]")
    return figure


def forces(traces: SessionTraces, scenario: Scenario | None) -> Any:
    """Draw the forces on device and avatar, one row per user, along the axis of the task."""
    server, colours = traces.server, style.colours(traces)
    if not traces.users:
        return None
    figure, rows = style.canvas(
        len(traces.users), title=style.title("Forces", scenario), note=style.note(traces, scenario)
    )
    limits = {user.name: user.safety.max_force for user in scenario.users} if scenario else {}
    for axes, user in zip(rows, traces.users, strict=True):
        tint = colours[user.name]
        if np.isfinite(user.f_h).any():
            axes.plot(user.time_s, user.f_h[:, 0], color="#9A9A9A", lw=1.0, label="hand on device")
        axes.plot(user.time_s, user.f_applied[:, 0], color=tint, lw=1.8, label="device on hand")
        if server is not None and user.name in server.users:
            place = server.users.index(user.name)
            axes.plot(
                server.time_s,
                server.f_s[place][:, 0],
                color=style.OBJECT,
                ls="--",
                lw=1.2,
                label="contact on avatar",
            )
        low, high = axes.get_ylim()
        limit = limits.get(user.name, np.inf)
        near = [edge for edge, seen in ((-limit, -low), (limit, high)) if seen > 0.7 * limit]
        for place, edge in enumerate(near):
            label = None if place else "limit"
            axes.axhline(edge, color=style.ALARM, lw=1.0, ls=":", label=label)
        axes.set_title(user.name, color=tint, fontweight="bold")
        along = "" if user.f_applied.shape[1] == 1 else f", {style.AXES[0]}"
        axes.set_ylabel(f"force{along} [N]")
        style.legend(axes)
    rows[-1].set_xlabel("time [s]")
    return figure


FIGURES: dict[str, tuple[Draw, str, str]] = {
    "positions": (
        motion,
        "Positions",
        "Solid: the devices in the users' hands. Dashed: their avatars in the shared world. "
        "Black: the object; dotted grey: where it is to be brought. A device ahead of its avatar "
        "is the link's own compliance.",
    ),
    "forces": (
        forces,
        "Forces",
        "What the hand exerts on the device, what the device renders, and the contact force at "
        "the avatar (along the axis of the task). At rest the last two agree.",
    ),
    "energy": (
        energy,
        "Energy balance of the channel",
        "What went into each direction of the link, less what came out. A passive channel never "
        "is below zero; where it is, the stretch is hatched.",
    ),
    "budget": (
        whereabouts,
        "Energy budget over time",
        "What the hands have given (black) and where it is: stored, turned to heat, or under way. "
        "What is below zero was given out without having been taken in; the parts that did so "
        "have a row of their own.",
    ),
    "controller": (
        bookings,
        "Energies of the controller",
        "What the controller booked itself: taken, given out, held back, saved.",
    ),
    "network": (
        network,
        "Network",
        "Each dot is a packet: when it came to the link, and how long it took. Crosses at the "
        "bottom are packets that were lost or dropped.",
    ),
    "loop": (
        loop,
        "Force loop",
        "How late each tick of the force loop woke up. Its deadlines are absolute, so lateness "
        "does not add up.",
    ),
}
