# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A whole session as one loop over its ticks, made to be compiled: users, server, and what the
plan of the network says of their packets (:mod:`.plan`).

Per tick: frames that start send their packets; the server steps where it is its turn; every user's
loop and device run. Whatever is to be known of the session is written into arrays. An array is
handed on by itself, never within a tuple: to take one out of a tuple costs more than a law.
"""

import math
from typing import Any, NamedTuple

from pmwvc_core.law.channel.arrivals import arrivals_of
from pmwvc_core.law.channel.packet import Packet
from pmwvc_core.law.plant.device import device_step
from pmwvc_core.law.plant.forces import hand_step
from pmwvc_core.law.port.master import port_energies, port_opened, port_signals
from pmwvc_core.law.port.sensing import Sample
from pmwvc_core.law.server.energies import environment_energies, port_shown
from pmwvc_core.law.server_step import Answer, Guest, GuestParams, Server, server_step
from pmwvc_core.law.user_tick import User, begin, send, user_tick
from pmwvc_core.law.vectors import Vector, columns, each, squared
from pmwvc_core.numeric import Array, Integers

OF_PACKET = 7  # columns behind wave, integral and position: energy, period, time, flags, echo


class End(NamedTuple):
    """A user with device and hand; how many packets it has sent, and blocks it has written."""

    user: User
    device: Any
    hand: Any
    acts: bool
    sent: int
    blocks: int


class EndParams(NamedTuple):
    """Their parameters."""

    user: Any
    device: Any
    hand: Any


class Clock(NamedTuple):
    """Ticks of the session, their length, frames and the server's steps in ticks; numbers of the
    users and of the axes: 0, 1 ...
    """

    ticks: int
    tick_ns: int
    rate_drops: tuple[int, ...]
    period_ticks: int
    users: tuple[int, ...]
    axes: tuple[int, ...]


class Book(NamedTuple):
    """What a session reads and writes.

    Attributes
    ----------
    up, down
        Packets accepted, ``(accepted, 5)`` in the order of time: tick, user, which of those sent
        from 0, whether it is a beginning, how many were lost before it.
    packets
        Sent, by link ``(2 users, packets, 3 axes + OF_PACKET)``: up and down of each user.
    signals
        ``(users, 8, ticks, axes)``.
    blocks
        ``(users, blocks, 4 + energies)``: cause, interventions, work, energies of the port.
    steps, energies, presence
        Of the server: ``(2 + 5 users, steps, axes)``, ``(steps, 4 + 4 users + accounts)``,
        ``(steps, users)``.
    """

    up: Integers
    down: Integers
    packets: Array
    signals: Array
    blocks: Array
    steps: Array
    energies: Array
    presence: Integers


def session(
    ends: tuple[End, ...], server: Server, users: tuple[EndParams, ...], p: Any, clock: Clock,
    book: Book,
) -> bool:  # fmt: skip
    """Run a session; tell whether all went by the plan."""
    up, down, packets, signals = book.up, book.down, book.packets, book.signals
    blocks, steps, energies, presence = book.blocks, book.steps, book.energies, book.presence
    nothing = each(_zero, (clock.axes,))
    ends = each(_opened_end, (ends,), nothing)
    guests = each(_opened_guest, (server.guests,), nothing)
    server = Server(guests, server.environment, server.task_s)
    posted = each(_none, (clock.users,))
    empty = [ends[0].user.newest]
    empty.pop()
    none = each(_empty, (clock.users,), empty)
    step, next_step, taken_up, taken_down = 0, 0, 0, 0
    for tick in range(clock.ticks):
        now_ns, last = tick * clock.tick_ns, tick + 1 == clock.ticks
        if begins(tick, clock):
            ends = each(_sent, (ends, users, clock.users), tick, now_ns, packets)
        if tick == next_step:
            since, taken_up = taken_up, after(up, taken_up, tick)
            longest = each(_longest_up, (p.guests,))
            came, fit = columns(
                each(_taken, (clock.users, longest), 0, up, since, taken_up, packets, empty, clock)
            )
            if not all_of(fit):
                return False
            server, answers = server_step(server, now_ns, came, 0.0, p)
            posted = each(_posted, (answers, posted, clock.users), packets)
            _note_step(server, step, p, steps, energies, presence)
            step, next_step = step + 1, next_step + clock.period_ticks
        arrived = none
        if taken_down < len(down) and down[taken_down, 0] <= tick:
            since, taken_down = taken_down, after(down, taken_down, tick)
            longest = each(_longest_down, (users,))
            arrived, fit = columns(
                each(
                    _taken, (clock.users, longest), 1, down, since, taken_down, packets, empty,
                    clock,
                )
            )  # fmt: skip
            if not all_of(fit):
                return False
        ends = each(_ran, (ends, users, arrived, clock.users), tick, now_ns, signals)
        if last or begins(tick + 1, clock):
            ends = each(_noted, (ends, users, clock.users), tick, last, blocks)
    return True


def begins(tick: int, clock: Clock) -> bool:
    """Tell whether a frame of any user begins with a tick."""
    found = False
    for i in range(len(clock.rate_drops)):
        found = found or tick % clock.rate_drops[i] == 0
    return found


def all_of(flags: tuple[bool, ...]) -> bool:
    """Tell whether all of them are set."""
    every = True
    for i in range(len(flags)):
        every = every and flags[i]
    return every


def after(rows: Integers, row: int, tick: int) -> int:
    """Return the first row behind those up to a tick."""
    while row < len(rows) and rows[row, 0] <= tick:
        row += 1
    return row


def _zero(axis: int) -> float:
    return 0.0


def _none(user: int) -> int:
    return 0


def _empty(user: int, empty: list[Packet]) -> list[Packet]:
    return empty


def _longest_up(p: GuestParams) -> float:
    return p.arrivals.longest  # type: ignore[no-any-return]


def _longest_down(p: EndParams) -> float:
    return p.user.arrivals.longest  # type: ignore[no-any-return]


def _opened_end(s: End, nothing: Vector) -> End:
    u = s.user
    user = User(u.frames, u.frame_s, u.packing, arrivals_of(u.arrivals, nothing), u.newest,
                u.servers, port_opened(u.port), u.limits, u.sensing, u.due, u.coupled)  # fmt: skip
    return End(user, s.device, s.hand, s.acts, s.sent, s.blocks)


def _opened_guest(s: Guest, nothing: Vector) -> Guest:
    return Guest(s.presence, s.anew, arrivals_of(s.arrivals, nothing), s.packing, s.extra)


def _sent(s: End, p: EndParams, number: int, tick: int, now_ns: int, packets: Array) -> End:
    """Start a frame, if it is time."""
    if tick < s.user.frames.next_frame:
        return s
    sample = Sample(s.device.read_x, s.device.read_xd, True, now_ns)
    user, packet, _ = send(s.user, now_ns, sample, False, p.user)
    _write(packet, 2 * number, s.sent, packets)
    return End(begin(user, tick, p.user), s.device, s.hand, s.acts, s.sent + 1, s.blocks)


def _posted(answer: Answer, posted: int, number: int, packets: Array) -> int:
    if not answer.sends:
        return posted
    _write(answer.packet, 2 * number + 1, posted, packets)
    return posted + 1


def _write(packet: Packet, link: int, row: int, packets: Array) -> None:
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


def _taken(
    number: int, longest: float, way: int, rows: Integers, since: int, until: int, packets: Array,
    empty: list[Packet], clock: Clock,
) -> tuple[list[Packet], bool]:  # fmt: skip
    """Return a user's packets among the rows accepted now, and whether all are fit."""
    taken, fit, n, link = empty.copy(), True, len(clock.axes), 2 * number + way
    for row in range(since, until):
        if rows[row, 1] == number:
            k = rows[row, 2]
            wave = each(_element, (clock.axes,), packets, link, k, 0)
            integral = each(_element, (clock.axes,), packets, link, k, n)
            position = each(_element, (clock.axes,), packets, link, k, 2 * n)
            fit = fit and squared(wave) <= longest**2  # not so where it is no number
            taken.append(Packet(
                k + 1, int(packets[link, k, 3 * n + 2]), packets[link, k, 3 * n + 1], wave,
                integral, packets[link, k, 3 * n], position, packets[link, k, 3 * n + 3] != 0.0,
                packets[link, k, 3 * n + 4] != 0.0, packets[link, k, 3 * n + 5] != 0.0, False, (),
                int(packets[link, k, 3 * n + 6]), rows[row, 3] != 0, rows[row, 4], 0,
            ))  # fmt: skip
    return taken, fit


def _element(axis: int, packets: Array, link: int, row: int, first: int) -> float:
    return float(packets[link, row, first + axis])


def _ran(
    s: End, p: EndParams, packets: list[Packet], number: int, tick: int, now_ns: int,
    signals: Array,
) -> End:  # fmt: skip
    """Run a tick of a user's loop and device."""
    device, acts = s.device, s.acts or s.user.limits.fading.ready
    # The hand is in touch with the device itself, not with its encoder.
    hand, f_h = hand_step(s.hand, device.x, device.xd, acts, p.hand)
    sample = Sample(device.read_x, device.read_xd, True, now_ns)
    user, out = user_tick(s.user, tick, now_ns, sample, packets, p.user)
    u_m, u_m_lp, v_m = port_signals(user.port)
    for i in range(len(f_h)):
        signals[number, 0, tick, i] = sample.x[i]
        signals[number, 1, tick, i] = sample.xd[i]
        signals[number, 2, tick, i] = f_h[i]
        signals[number, 3, tick, i] = out.f_m[i]
        signals[number, 4, tick, i] = out.f[i]
        signals[number, 5, tick, i] = u_m[i]
        signals[number, 6, tick, i] = u_m_lp[i]
        signals[number, 7, tick, i] = v_m[i]
    device, _, _ = device_step(device, f_h, out.f, p.device)
    return End(user, device, hand, acts, s.sent, s.blocks)


def _noted(s: End, p: EndParams, number: int, tick: int, last: bool, blocks: Array) -> End:
    """Note a frame that is over."""
    if not last and tick + 1 < s.user.frames.next_frame:
        return s
    user, k = s.user, s.blocks
    blocks[number, k, 0] = user.limits.cause
    blocks[number, k, 1] = user.limits.interventions.events
    blocks[number, k, 2] = s.device.against_j
    blocks[number, k, 3] = s.device.by_hand_j
    energies = port_energies(user.port, user.arrivals, p.user.port)
    for i in range(len(energies)):
        blocks[number, k, 4 + i] = energies[i]
    return End(user, s.device, s.hand, s.acts, s.sent, k + 1)


def _note_step(
    server: Server, row: int, p: Any, steps: Array, energies: Array, presence: Integers
) -> None:
    at = server.environment
    counted, first = environment_energies(p.environment, at), 4 + 4 * len(at.ports)
    energies[row, 0] = counted[0]
    energies[row, 1] = counted[1]
    for i in range(2, len(counted)):
        energies[row, first + i - 2] = counted[i]
    energies[row, 2] = at.dissipated_j
    energies[row, 3] = max(server.task_s, 0.0) if server.task_s < math.inf else 0.0
    for i in range(len(at.body.x)):
        steps[0, row, i] = at.body.x[i]
        steps[1, row, i] = at.body.xd[i]
    for k in range(len(at.ports)):
        port = at.ports[k]
        presence[row, k] = server.guests[k].presence
        seen = port_shown(p.environment, at, k)
        energies[row, 4 + 4 * k] = port.sums.u_j
        energies[row, 5 + 4 * k] = port.sums.v_j
        energies[row, 6 + 4 * k] = seen.touches
        energies[row, 7 + 4 * k] = seen.learned
        for i in range(len(port.x_s)):
            steps[2 + 5 * k, row, i] = port.x_s[i]
            steps[3 + 5 * k, row, i] = port.avatar.xd[i]
            steps[4 + 5 * k, row, i] = port.avatar.f[i]
            steps[5 + 5 * k, row, i] = port.avatar.u[i]
            steps[6 + 5 * k, row, i] = seen.v_s[i]
