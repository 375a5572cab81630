# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The arrays of a session in bulk: packets written and taken out again, steps of the server."""

import math
from typing import Any, NamedTuple

from pmwvc_core.law.channel.packet import Packet
from pmwvc_core.law.server.server_port import environment_energies, port_shown
from pmwvc_core.law.server_step import Server
from pmwvc_core.law.vectors import Vector, each, squared
from pmwvc_core.numeric import Array, Integers
from pmwvc_core.plant.forces import Task, offset

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


def put(values: Vector, into: Array, first: int) -> None:
    """Write values one after the other into a row."""
    for i in range(len(values)):
        into[first + i] = values[i]


def write(packet: Packet, link: int, packets: Array) -> None:
    """Write a packet that a link carries into the row of its number."""
    times = packet.energy_j, packet.period_s, float(packet.sent_ns)
    flags = 1.0 * packet.short, 1.0 * packet.waits, 1.0 * packet.anew  # float() takes no flag
    rest = *times, *flags, float(packet.echo)
    into = packets[link, packet.number - 1]
    put(packet.wave + packet.integral + packet.position + rest, into, 0)


def taken(
    number: int, p: Any, way: int, rows: Integers, since: int, until: int, packets: Array,
    empty: list[Packet], axes: tuple[int, ...],
) -> tuple[list[Packet], bool]:  # fmt: skip
    """Return a user's packets among the rows accepted now, and whether all are fit; ``p`` are the
    parameters of the end that takes them.
    """
    found, fit, n, link = empty.copy(), True, len(axes), 2 * number + way
    for row in range(since, until):
        if rows[row, 1] == number:
            k = rows[row, 2]
            wave = each(_element, (axes,), packets, link, k, 0)
            integral = each(_element, (axes,), packets, link, k, n)
            position = each(_element, (axes,), packets, link, k, 2 * n)
            fit = fit and squared(wave) <= p.arrivals.longest**2  # not so where it is no number
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
    at, users = server.environment, len(server.environment.ports)
    counted = environment_energies(p.environment, at)
    put(counted[:2], energies[row], 0)
    put(counted[2:], energies[row], 3 + 4 * users)
    energies[row, 2] = at.dissipated_j
    target = offset(max(server.task_s, 0.0) if server.task_s < math.inf else 0.0, task)
    put(target, steps[len(steps) - 1, row], 0)
    put(at.body.x, steps[0, row], 0)
    put(at.body.xd, steps[1, row], 0)
    for k in range(users):
        port, seen, first = at.ports[k], port_shown(p.environment, at, k), 2 + 5 * k
        presence[row, k] = server.guests[k].presence
        shown = port.u_j, port.v_j, 1.0 * seen.touches, seen.learned
        put(shown, energies[row], 3 + 4 * k)
        put(port.x_s, steps[first, row], 0)
        put(port.avatar.xd, steps[first + 1, row], 0)
        put(port.avatar.f, steps[first + 2, row], 0)
        put(port.avatar.u, steps[first + 3, row], 0)
        put(seen.v_s, steps[first + 4, row], 0)
