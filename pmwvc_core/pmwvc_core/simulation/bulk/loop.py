# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A whole session as one loop over its ticks, made to be compiled: users, server, and what the
plan of the network says of their packets (:mod:`.plan`).

The server steps; then loop and device of every user, one after the other, run up to the next step:
they meet in packets alone. Where a frame is over, its packet leaves. The arrays of a book are each
handed on by themselves: to take one out of a tuple costs more than a law. The state of each end
stands in a list of one: as a variable all of it would be copied wherever branches meet.
"""

import math
from typing import Any, NamedTuple

from pmwvc_core.law.channel.packet import Packet
from pmwvc_core.law.family import opened
from pmwvc_core.law.port.master import port_energies, port_signals
from pmwvc_core.law.server.server_port import port_shown, scene_energies
from pmwvc_core.law.server_step import Guest, Server, server_step
from pmwvc_core.law.user_tick import ForceLoop, Sample, begin, receive, send, user_tick
from pmwvc_core.law.vectors import Vector, columns, each, squared
from pmwvc_core.numeric import Array, Integers
from pmwvc_core.plant.device import device_step
from pmwvc_core.plant.forces import Task, hand_force, offset

OF_PACKET = 8  # columns behind wave, integral, position: energy, period, time, flags, echo, level


class Book(NamedTuple):
    """What a session reads and writes."""

    # Packets accepted in order ``(accepted, 5)``: tick, user, number from 0, anew, lost before it.
    up: Integers
    down: Integers
    packets: Array  # sent, by link ``(2 users, packets, 3 axes + OF_PACKET)``: up and down of each
    signals: Array  # ``(users, 8, ticks, axes)``
    blocks: Array  # ``(users, blocks, 4 + energies)``: cause, interventions, work; of the port
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
    rest = *times, *flags, float(packet.echo), float(packet.level)
    signals = packet.wave + packet.integral + packet.position
    put(signals + rest, packets[link, packet.number - 1], 0)


def taken(
    number: int, p: Any, way: int, rows: Integers, since: int, until: int, packets: Array,
    empty: list[Packet], axes: tuple[int, ...],
) -> tuple[list[Packet], bool]:  # fmt: skip
    """Return a user's packets among rows accepted now, and whether the end takes them (its p)."""
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
                packets[link, k, 3 * n + 4] != 0.0, packets[link, k, 3 * n + 5] != 0.0, False,
                int(packets[link, k, 3 * n + 7]), (),
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
    counted = scene_energies(p.environment, at)
    for k in range(len(counted)):  # accounts follow the two energies; there may be none
        energies[row, k if k < 2 else 1 + 4 * users + k] = counted[k]
    energies[row, 2] = at.dissipated_j
    target = offset(max(server.task_s, 0.0) if server.task_s < math.inf else 0.0, task)
    put(target, steps[len(steps) - 1, row], 0)
    put(at.body.x, steps[0, row], 0)
    put(at.body.xd, steps[1, row], 0)
    for k in range(users):
        port, seen, first = at.ports[k], port_shown(p.environment, at, k), 2 + 5 * k
        presence[row, k] = server.guests[k].presence
        put((port.u_j, port.v_j, 1.0 * seen.touches, seen.learned), energies[row], 3 + 4 * k)
        signals = port.x_s, port.avatar.xd, port.avatar.f, port.avatar.u, seen.v_s
        for i in range(len(signals)):
            put(signals[i], steps[first + i, row], 0)


class UserRun(NamedTuple):
    """A user with device and hand; how many rows of the plan it has passed."""

    user: ForceLoop
    device: Any
    hand: Any
    acts: bool
    taken: int


class EndParams(NamedTuple):
    """Their parameters."""

    user: Any
    device: Any
    hand: Any


class Clock(NamedTuple):
    """Ticks, their length, the server's steps in ticks; numbers of users and axes: 0, 1 ..."""

    ticks: int
    tick_ns: int
    period_ticks: int
    users: tuple[int, ...]
    axes: tuple[int, ...]


def session(
    ends: tuple[UserRun, ...], server: Server, users: tuple[EndParams, ...], p: Any, clock: Clock,
    task: Task, book: Book,
) -> bool:  # fmt: skip
    """Run a session; tell whether all went by the plan."""
    up, down, packets, signals = book.up, book.down, book.packets, book.signals
    blocks, steps, energies, presence = book.blocks, book.steps, book.energies, book.presence
    empty = [ends[0].user.newest]
    empty.pop()
    guests = each(_opened_guest, (server.guests,))
    serves = [Server(guests, server.environment, server.task_s)]
    runs = each(_opened_end, (ends, users, clock.users), packets)
    tick, step, taken_up = 0, 0, 0
    while tick < clock.ticks:
        since, taken_up = taken_up, after(up, taken_up, tick)
        rows = clock.users, p.guests
        came, fit = columns(each(taken, rows, 0, up, since, taken_up, packets, empty, clock.axes))
        if False in fit:
            return False
        serves[0], answers = server_step(serves[0], tick * clock.tick_ns, came, 0.0, p)
        each(_posted, (answers, clock.users), packets)
        note_step(serves[0], step, p, task, steps, energies, presence)
        fit = each(_ran, (runs, users, clock.users), tick, clock, empty, down, packets, signals,
                   blocks)  # fmt: skip
        if False in fit:
            return False
        tick, step = tick + clock.period_ticks, step + 1
    return True


def _opened_end(s: UserRun, p: EndParams, number: int, packets: Array) -> list[UserRun]:
    """Return the place of an end, which has sent its first packet."""
    arrivals, port = opened(s.user.arrivals), opened(s.user.port)
    at = [s._replace(user=s.user._replace(arrivals=arrivals, port=port))]
    _sent(at, p, number, 0, 0, packets)
    return at


def _opened_guest(s: Guest) -> Guest:
    return s._replace(arrivals=opened(s.arrivals))


def _sent(
    at: list[UserRun], p: EndParams, number: int, tick: int, now_ns: int, packets: Array
) -> None:
    """Start a frame: its packet leaves."""
    s = at[0]
    sample = Sample(s.device.read_x, s.device.read_xd, True, now_ns, False)
    user, packet, _ = send(s.user, now_ns, sample, False, p.user)
    write(packet, 2 * number, packets)
    at[0] = s._replace(user=begin(user, tick, p.user))


def _posted(answer: tuple[Packet, bool], number: int, packets: Array) -> bool:
    packet, sends = answer
    if sends:
        write(packet, 2 * number + 1, packets)
    return sends


def _ran(
    at: list[UserRun], p: EndParams, number: int, begin_tick: int, clock: Clock,
    empty: list[Packet], down: Integers, packets: Array, signals: Array, blocks: Array,
) -> bool:  # fmt: skip
    """Run a user up to the next step of the server; tell whether its packets were fit."""
    for tick in range(begin_tick, min(begin_tick + clock.period_ticks, clock.ticks)):
        now_ns, last = tick * clock.tick_ns, tick + 1 == clock.ticks
        taken_down = at[0].taken
        if taken_down < len(down) and down[taken_down, 0] <= tick:
            if not _receive(at, p, number, tick, now_ns, empty, down, packets, clock):
                return False
        s = at[0]
        device, acts = s.device, s.acts or s.user.limits.ready
        # The hand is in touch with the device itself, not with its encoder.
        hand, f_h = hand_force(s.hand, device.x, device.xd, acts, p.hand)
        sample = Sample(device.read_x, device.read_xd, True, now_ns, False)
        user, f_m, f = user_tick(s.user, tick, now_ns, sample, None, p.user)
        shown = sample.x, sample.xd, f_h, f_m, f, *port_signals(user.port)
        for k in range(len(shown)):
            put(shown[k], signals[number, k, tick], 0)
        device, _, _ = device_step(device, f_h, f, p.device)
        at[0] = s._replace(user=user, device=device, hand=hand, acts=acts)
        if last or tick + 1 >= user.next_frame:
            _note(at[0], p, number, blocks)
            if not last:
                _sent(at, p, number, tick + 1, now_ns + clock.tick_ns, packets)
    return True


def _receive(
    at: list[UserRun], p: EndParams, number: int, tick: int, now_ns: int, empty: list[Packet],
    down: Integers, packets: Array, clock: Clock,
) -> bool:  # fmt: skip
    """Take in what has come; tell whether it was fit."""
    s = at[0]
    until = after(down, s.taken, tick)
    came, fit = taken(number, p.user, 1, down, s.taken, until, packets, empty, clock.axes)
    at[0] = s._replace(user=receive(s.user, came, now_ns, p.user), taken=until)
    return fit


def _note(s: UserRun, p: EndParams, number: int, blocks: Array) -> None:
    """Note a frame that is over, in the row of its packet."""
    user, into = s.user, blocks[number, s.user.packing.number - 1]
    work_j = s.device.against_j, s.device.by_hand_j
    put((float(user.limits.cause), float(user.limits.events), *work_j), into, 0)
    put(port_energies(user.port, user.arrivals, p.user.port), into, 4)
