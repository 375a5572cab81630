# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Trace and fate messages as the feed takes them. No ROS is imported: messages are arguments."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from pmwvc_core.numeric import Array
from pmwvc_core.runtime.messages import nanoseconds
from pmwvc_view.accounts import MasterSums, ServerSums
from pmwvc_view.feed import NS, Block, Step

SAME_CLOCK_NS = 20_000_000  # clocks whose offsets differ by more are of two machines


def offset_ns(message: Any) -> int:
    """Return by how much ROS time is ahead of the monotonic clock of a trace's node [ns]."""
    return nanoseconds(message.stamp) - int(message.start_ns)


def block_of(message: Any, *, waves: bool, clock_ns: int | None) -> Block:
    """Return a MasterTrace as a block.

    Parameters
    ----------
    waves
        Whether its controller has waves.
    clock_ns
        Offset of the server's clock; None where it is not known yet. A master whose clock is of
        another machine is put beside it by ROS time, and its energy is not compared.
    """
    dof, ticks = int(message.dof), len(message.lateness)

    def signal(name: str) -> Array:
        values = np.asarray(getattr(message, name), dtype=np.float64)
        return values.reshape(ticks, dof) if len(values) else np.full((ticks, dof), math.nan)

    period_ns = round(message.period * NS)
    start_ns = int(message.start_ns)
    late = np.asarray(message.lateness, dtype=np.float64)
    sums: MasterSums | None = MasterSums(
        start_ns + (ticks - 1) * period_ns + round(float(late[-1]) * NS),
        int(message.epoch),
        message.energy_u_m,
        message.energy_v_m,
        message.energy_device,
    )
    if clock_ns is not None and abs(offset_ns(message) - clock_ns) > SAME_CLOCK_NS:
        start_ns += offset_ns(message) - clock_ns
        sums = None
    return Block(
        start_ns=start_ns,
        period_ns=period_ns,
        x=signal("x"),
        xd=signal("xd"),
        f_h=signal("f_h") if message.hand_force_known else np.full((ticks, dof), math.nan),
        f_applied=signal("f_applied"),
        u_m=signal("u_m"),
        v_m=signal("v_m"),
        lateness_s=late,
        state=int(message.state),
        reason=str(message.reason),
        missed=int(message.missed),
        sums=sums,
        waves=waves and not message.account_names,
    )


def step_of(message: Any) -> Step:
    """Return a ServerTrace as a step."""
    dof, users = int(message.dof), len(message.users)

    def each(name: str) -> Array:
        return np.asarray(getattr(message, name), dtype=np.float64).reshape(users, dof)

    start_ns = int(message.start_ns)
    ran_ns = start_ns + round(message.lateness * NS)
    return Step(
        start_ns=start_ns,
        x_o=np.asarray(message.x_o, dtype=np.float64),
        xd_o=np.asarray(message.xd_o, dtype=np.float64),
        target=np.asarray(message.target, dtype=np.float64),
        x_s=each("x_s"),
        xd_s=each("xd_s"),
        f_s=each("f_s"),
        state=[int(state) for state in message.state],
        contact=[bool(contact) for contact in message.contact],
        lateness_s=float(message.lateness),
        sums={
            name: ServerSums(ran_ns, int(message.epoch), u_s, v_s)
            for name, u_s, v_s in zip(
                message.users, message.energy_u_s, message.energy_v_s, strict=True
            )
        },
    )


def packets_of(message: Any) -> Array:
    """Return a PacketFate as packets: number, time in and out [ns], fate."""
    count = len(message.time_in_ns)
    found = np.empty((count, 4))
    found[:, 0] = np.arange(message.first, message.first + count)
    for column, name in enumerate(("time_in_ns", "time_out_ns", "fate"), start=1):
        found[:, column] = np.asarray(getattr(message, name), dtype=np.float64)
    return found


def link_number(link: str, users: Sequence[str]) -> int | None:
    """Return the number of a link in snapshots; None for one that is no user's."""
    user, _, way = link.rpartition("/")
    if user not in users or way not in ("up", "down"):
        return None
    return 2 * list(users).index(user) + (way == "down")
