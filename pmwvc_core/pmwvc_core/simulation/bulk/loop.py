# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A whole session as one loop over its ticks, made to be compiled: users, server, and what the
plan of the network says of their packets (:mod:`.plan`).

The server steps; then loop and device of every user, one after the other, run up to the next step:
they meet in packets alone. Where a frame is over, its packet leaves. What is to be known of the
session is written into arrays (:mod:`.book`), each handed on by itself, never within a tuple: to
take one out of a tuple costs more than a law. The state of each end stands in a list of one: as a
variable all of it would be copied wherever branches meet.
"""

from typing import Any, NamedTuple

from pmwvc_core.law.channel.packet import Packet
from pmwvc_core.law.family import opened
from pmwvc_core.law.port.master import Sample, port_energies, port_signals
from pmwvc_core.law.server_step import Guest, Server, server_step
from pmwvc_core.law.user_tick import ForceLoop, begin, receive, send, user_tick
from pmwvc_core.law.vectors import columns, each
from pmwvc_core.numeric import Array, Integers
from pmwvc_core.plant.device import device_step
from pmwvc_core.plant.forces import Task, hand_force
from pmwvc_core.simulation.bulk.book import Book, after, note_step, put, taken, write


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
    """Ticks of the session, their length, the server's steps in ticks; numbers of the users and of
    the axes: 0, 1 ...
    """

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
    axes = clock.axes
    empty = [ends[0].user.newest]
    empty.pop()
    guests = each(_opened_guest, (server.guests,))
    serves = [Server(guests, server.environment, server.task_s)]
    runs = each(_opened_end, (ends, users, clock.users), packets)
    tick, step, taken_up = 0, 0, 0
    while tick < clock.ticks:
        since, taken_up = taken_up, after(up, taken_up, tick)
        came, fit = columns(
            each(taken, (clock.users, p.guests), 0, up, since, taken_up, packets, empty, axes)
        )
        if not all_of(fit):
            return False
        serves[0], answers = server_step(serves[0], tick * clock.tick_ns, came, 0.0, p)
        each(_posted, (answers, clock.users), packets)
        note_step(serves[0], step, p, task, steps, energies, presence)
        fit = each(_ran, (runs, users, clock.users), tick, clock, empty, down, packets, signals,
                   blocks)  # fmt: skip
        if not all_of(fit):
            return False
        tick, step = tick + clock.period_ticks, step + 1
    return True


def all_of(flags: tuple[bool, ...]) -> bool:
    """Tell whether all of them are set."""
    every = True
    for i in range(len(flags)):
        every = every and flags[i]
    return every


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
    sample = Sample(s.device.read_x, s.device.read_xd, True, now_ns)
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
    """Run a user's loop and device up to the next step of the server; tell whether its packets
    were fit.
    """
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
        sample = Sample(device.read_x, device.read_xd, True, now_ns)
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
