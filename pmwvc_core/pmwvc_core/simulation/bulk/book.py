# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The arrays of a session in bulk: packets written and taken out again, steps of the server."""

import math
from typing import Any, NamedTuple

from pmwvc_core.law.channel.packet import Packet
from pmwvc_core.law.server.server_port import environment_energies, port_shown
from pmwvc_core.law.server_step import Server
from pmwvc_core.law.vectors import each, squared
from pmwvc_core.numeric import Array, Integers
from pmwvc_core.plant.task import Task, offset

OF_PACKET = 7  # columns behind wave, integral and position: energy, period, time, flags, echo


class Book(NamedTuple):
    """What a session reads and writes."""

    # Packets accepted in the order of time ``(accepted, 5)``: tick, user, which of those sent from
    # 0, whether it is a beginning, how many were lost before it.
    up: Integers
    down: Integers
    packets: Array  # sent, by link ``(2 users, packets, 3 axes + OF_PACKET)``: up and down of each
    signals: Array  # ``(users, 8, ticks, axes)``
    # ``(users, blocks, 4 + energies)``: cause, interventions, work, energies of the port
    blocks: Array
    steps: Array  # of the server ``(3 + 5 users, steps, axes)``, the last of them the target
    energies: Array  # ``(steps, 3 + 4 users + accounts)``
    presence: Integers  # ``(steps, users)``


def after(rows: Integers, row: int, tick: int) -> int:
    """Return the first row behind those up to a tick."""
    while row < len(rows) and rows[row, 0] <= tick:
        row += 1
    return row


def write(packet: Packet, link: int, row: int, packets: Array) -> None:
    """Write a packet that a link carries."""
    n = len(packet.wave)
    for i in range(n):
        packets[link, row, i] = packet.wave[i]
        packets[link, row, n + i] = packet.integral[i]
        packets[link, row, 2 * n + i] = packet.position[i]
    packets[link, row, 3 * n] = packet.energy_j
    packets[link, row, 3 * n + 1] = packet.period_s
    packets[link, row, 3 * n + 2] = packet.sent_ns
    packets[link, row, 3 * n + 3] = packet.short
    packets[link, row, 3 * n + 4] = packet.waits
    packets[link, row, 3 * n + 5] = packet.anew
    packets[link, row, 3 * n + 6] = packet.echo


def taken(
    number: int, longest: float, way: int, rows: Integers, since: int, until: int, packets: Array,
    empty: list[Packet], axes: tuple[int, ...],
) -> tuple[list[Packet], bool]:  # fmt: skip
    """Return a user's packets among the rows accepted now, and whether all are fit."""
    found, fit, n, link = empty.copy(), True, len(axes), 2 * number + way
    for row in range(since, until):
        if rows[row, 1] == number:
            k = rows[row, 2]
            wave = each(_element, (axes,), packets, link, k, 0)
            integral = each(_element, (axes,), packets, link, k, n)
            position = each(_element, (axes,), packets, link, k, 2 * n)
            fit = fit and squared(wave) <= longest**2  # not so where it is no number
            found.append(Packet(
                k + 1, int(packets[link, k, 3 * n + 2]), packets[link, k, 3 * n + 1], wave,
                integral, packets[link, k, 3 * n], position, packets[link, k, 3 * n + 3] != 0.0,
                packets[link, k, 3 * n + 4] != 0.0, packets[link, k, 3 * n + 5] != 0.0, False, (),
                int(packets[link, k, 3 * n + 6]), rows[row, 3] != 0, rows[row, 4], 0,
            ))  # fmt: skip
    return found, fit


def _element(axis: int, packets: Array, link: int, row: int, first: int) -> float:
    return float(packets[link, row, first + axis])


def note_step(
    server: Server, row: int, p: Any, task: Task, steps: Array, energies: Array, presence: Integers
) -> None:
    """Note a step of the server."""
    at = server.environment
    counted, first = environment_energies(p.environment, at), 3 + 4 * len(at.ports)
    energies[row, 0] = counted[0]
    energies[row, 1] = counted[1]
    for i in range(2, len(counted)):
        energies[row, first + i - 2] = counted[i]
    energies[row, 2] = at.dissipated_j
    target = offset(max(server.task_s, 0.0) if server.task_s < math.inf else 0.0, task)
    for i in range(len(target)):
        steps[len(steps) - 1, row, i] = target[i]
    for i in range(len(at.body.x)):
        steps[0, row, i] = at.body.x[i]
        steps[1, row, i] = at.body.xd[i]
    for k in range(len(at.ports)):
        port = at.ports[k]
        presence[row, k] = server.guests[k].presence
        seen = port_shown(p.environment, at, k)
        energies[row, 3 + 4 * k] = port.u_j
        energies[row, 4 + 4 * k] = port.v_j
        energies[row, 5 + 4 * k] = seen.touches
        energies[row, 6 + 4 * k] = seen.learned
        for i in range(len(port.x_s)):
            steps[2 + 5 * k, row, i] = port.x_s[i]
            steps[3 + 5 * k, row, i] = port.avatar.xd[i]
            steps[4 + 5 * k, row, i] = port.avatar.f[i]
            steps[5 + 5 * k, row, i] = port.avatar.u[i]
            steps[6 + 5 * k, row, i] = seen.v_s[i]
