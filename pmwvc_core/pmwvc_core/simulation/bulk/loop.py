# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A whole session as one loop over its ticks, made to be compiled: users, server, and what the
plan of the network says of their packets (:mod:`.plan`).

Per tick: frames that start send their packets; the server steps where it is its turn; every user's
loop and device run. What is to be known of the session is written into arrays (:mod:`.book`), each
handed on by itself, never within a tuple: to take one out of a tuple costs more than a law.
"""

from typing import Any, NamedTuple

from pmwvc_core.law.channel.arrivals import arrivals_of
from pmwvc_core.law.channel.packet import Packet
from pmwvc_core.law.port.master import port_energies, port_opened, port_signals
from pmwvc_core.law.port.sensing import Sample
from pmwvc_core.law.server_step import Answer, Guest, GuestParams, Server, server_step
from pmwvc_core.law.user_tick import User, begin, send, user_tick
from pmwvc_core.law.vectors import Vector, columns, each
from pmwvc_core.numeric import Array
from pmwvc_core.plant.device import device_step
from pmwvc_core.plant.forces import hand_step
from pmwvc_core.plant.task import Task
from pmwvc_core.simulation.bulk.book import Book, after, note_step, taken, write


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


def session(
    ends: tuple[End, ...], server: Server, users: tuple[EndParams, ...], p: Any, clock: Clock,
    task: Task, book: Book,
) -> bool:  # fmt: skip
    """Run a session; tell whether all went by the plan."""
    up, down, packets, signals = book.up, book.down, book.packets, book.signals
    blocks, steps, energies, presence = book.blocks, book.steps, book.energies, book.presence
    axes, posted = clock.axes, each(_none, (clock.users,))
    nothing = each(_zero, (axes,))
    ends = each(_opened_end, (ends,), nothing)
    guests = each(_opened_guest, (server.guests,), nothing)
    server = Server(guests, server.environment, server.task_s)
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
                each(taken, (clock.users, longest), 0, up, since, taken_up, packets, empty, axes)
            )
            if not all_of(fit):
                return False
            server, answers = server_step(server, now_ns, came, 0.0, p)
            posted = each(_posted, (answers, posted, clock.users), packets)
            note_step(server, step, p, task, steps, energies, presence)
            step, next_step = step + 1, next_step + clock.period_ticks
        arrived = none
        if taken_down < len(down) and down[taken_down, 0] <= tick:
            since, taken_down = taken_down, after(down, taken_down, tick)
            longest = each(_longest_down, (users,))
            arrived, fit = columns(
                each(
                    taken, (clock.users, longest), 1, down, since, taken_down, packets, empty, axes
                )
            )
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
    arrivals, port = arrivals_of(s.user.arrivals, nothing), port_opened(s.user.port)
    return s._replace(user=s.user._replace(arrivals=arrivals, port=port))


def _opened_guest(s: Guest, nothing: Vector) -> Guest:
    return s._replace(arrivals=arrivals_of(s.arrivals, nothing))


def _sent(s: End, p: EndParams, number: int, tick: int, now_ns: int, packets: Array) -> End:
    """Start a frame, if it is time."""
    if tick < s.user.frames.next_frame:
        return s
    sample = Sample(s.device.read_x, s.device.read_xd, True, now_ns)
    user, packet, _ = send(s.user, now_ns, sample, False, p.user)
    write(packet, 2 * number, s.sent, packets)
    return End(begin(user, tick, p.user), s.device, s.hand, s.acts, s.sent + 1, s.blocks)


def _posted(answer: Answer, posted: int, number: int, packets: Array) -> int:
    if not answer.sends:
        return posted
    write(answer.packet, 2 * number + 1, posted, packets)
    return posted + 1


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
    blocks[number, k, 1] = user.limits.events
    blocks[number, k, 2] = s.device.against_j
    blocks[number, k, 3] = s.device.by_hand_j
    energies = port_energies(user.port, user.arrivals, p.user.port)
    for i in range(len(energies)):
        blocks[number, k, 4 + i] = energies[i]
    return End(user, s.device, s.hand, s.acts, s.sent, k + 1)
