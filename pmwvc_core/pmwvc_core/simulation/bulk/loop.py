# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A whole session as one loop over its ticks, made to be compiled: users, server, and what the
plan of the network says of their packets (:mod:`.plan`).

The server steps; then loop and device of every user, one after the other, run up to the next step:
they meet in packets alone. Where a frame is over, its packet leaves; every link keeps what it has
carried. The arrays of a book are each handed on by themselves: to take one out of a tuple costs
more than a law. The state of each end stands in a list of one: as a variable all of it would be
copied wherever branches meet.
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

OF_PACKET = 3  # columns behind wave, integral, position: energy, period, time


class Taken(NamedTuple):
    """What a receiver takes of the packets of its link, in order, by the plan of the network."""

    rows: Integers  # ``(taken, 3)``: number of the packet from 0, anew, lost before it
    before: Integers  # how many before each step of the server, or tick of a master, and in all


class Book(NamedTuple):
    """What a session writes."""

    packets: Array  # sent, by link ``(2 users, packets, 3 axes + OF_PACKET)``: up and down of each
    signals: Array  # ``(users, 8, ticks, axes)``
    blocks: Array  # ``(users, blocks, 4 + energies)``: cause, interventions, work; of the port
    steps: Array  # of the server ``(3 + 5 users, steps, axes)``, the last of them the target
    energies: Array  # ``(steps, 3 + 4 users + accounts)``
    presence: Integers  # ``(steps, users)``


def put(values: Vector, into: Array, first: int) -> None:
    """Write values one after the other into a row."""
    for i in range(len(values)):
        into[first + i] = values[i]


def write(sent: list[Packet], into: Array) -> None:
    """Write the packets that a link has carried, one a row."""
    for k in range(len(sent)):
        packet = sent[k]
        rest = packet.energy_j, packet.period_s, float(packet.sent_ns)
        put(packet.wave + packet.integral + packet.position + rest, into[k], 0)


def arrived(
    p: Any, plan: Taken, sent: list[Packet], look: int, empty: list[Packet]
) -> tuple[list[Packet], bool]:
    """Return what an end (its p) takes in its step or tick; whether no wave is too long for it."""
    found, fit, rows = empty.copy(), True, plan.rows
    for row in range(plan.before[look], plan.before[look + 1]):
        packet = sent[rows[row, 0]]
        fit = fit and squared(packet.wave) <= p.arrivals.longest**2  # not so where it is no number
        found.append(packet._replace(fresh=rows[row, 1] != 0, lost=rows[row, 2]))
    return found, fit


def note_step(
    server: Server, row: int, p: Any, task: Task, steps: Array, energies: Array, presence: Integers
) -> None:
    """Note a step of the server."""
    at, users = server.environment, len(server.environment.ports)
    counted = scene_energies(p.environment, at)
    for k in range(len(counted)):  # accounts follow the two energies; there may be none
        energies[row, k if k < 2 else 1 + 4 * users + k] = counted[k]
    energies[row, 2] = at.dissipated_j
    target = offset(server.task_s if server.task_s < math.inf else 0.0, task)
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
    """A user with device and hand."""

    user: ForceLoop
    device: Any
    hand: Any
    acts: bool


class EndParams(NamedTuple):
    """Their parameters."""

    user: Any
    device: Any
    hand: Any


class Clock(NamedTuple):
    """Ticks, their length, the server's steps in ticks; numbers of users: 0, 1 ..."""

    ticks: int
    tick_ns: int
    period_ticks: int
    users: tuple[int, ...]


def session(
    ends: tuple[UserRun, ...], server: Server, users: tuple[EndParams, ...], p: Any, clock: Clock,
    task: Task, up: tuple[Taken, ...], down: tuple[Taken, ...], book: Book,
) -> bool:  # fmt: skip
    """Run a session; tell whether all went by the plan."""
    packets, signals, blocks = book.packets, book.signals, book.blocks
    steps, energies, presence = book.steps, book.energies, book.presence
    empty = [ends[0].user.newest]
    empty.pop()
    guests = each(_opened_guest, (server.guests,))
    serves = [Server(guests, server.environment, server.task_s)]
    sent, answered = each(_none, (clock.users,), empty), each(_none, (clock.users,), empty)
    runs = each(_opened_end, (ends, users, sent))
    tick, step = 0, 0
    while tick < clock.ticks:
        came, fit = columns(each(arrived, (p.guests, up, sent), step, empty))
        if False in fit:
            return False
        serves[0], answers = server_step(serves[0], tick * clock.tick_ns, came, 0.0, p)
        each(_posted, (answers, answered))
        note_step(serves[0], step, p, task, steps, energies, presence)
        rows = runs, users, clock.users, down, sent, answered
        if False in each(_ran, rows, tick, clock, empty, signals, blocks):
            return False
        tick, step = tick + clock.period_ticks, step + 1
    for k in range(len(sent)):
        write(sent[k], packets[2 * k])
        write(answered[k], packets[2 * k + 1])
    return True


def _none(number: int, empty: list[Packet]) -> list[Packet]:
    return empty.copy()


def _opened_end(s: UserRun, p: EndParams, sent: list[Packet]) -> list[UserRun]:
    """Return the place of an end, which has sent its first packet."""
    arrivals, port = opened(s.user.arrivals), opened(s.user.port)
    at = [s._replace(user=s.user._replace(arrivals=arrivals, port=port))]
    _sent(at, p, 0, 0, sent)
    return at


def _opened_guest(s: Guest) -> Guest:
    return s._replace(arrivals=opened(s.arrivals))


def _sent(at: list[UserRun], p: EndParams, tick: int, now_ns: int, sent: list[Packet]) -> None:
    """Start a frame: its packet leaves."""
    s = at[0]
    sample = Sample(s.device.read_x, s.device.read_xd, True, now_ns, False)
    user, packet, _ = send(s.user, now_ns, sample, False, p.user)
    sent.append(packet)
    at[0] = s._replace(user=begin(user, tick, p.user))


def _posted(answer: tuple[Packet, bool], answered: list[Packet]) -> bool:
    packet, sends = answer
    if sends:
        answered.append(packet)
    return sends


def _ran(
    at: list[UserRun], p: EndParams, number: int, down: Taken, sent: list[Packet],
    answered: list[Packet], begin_tick: int, clock: Clock, empty: list[Packet], signals: Array,
    blocks: Array,
) -> bool:  # fmt: skip
    """Run a user up to the next step of the server; tell whether its packets were fit."""
    for tick in range(begin_tick, min(begin_tick + clock.period_ticks, clock.ticks)):
        now_ns, last = tick * clock.tick_ns, tick + 1 == clock.ticks
        if down.before[tick] < down.before[tick + 1]:
            came, fit = arrived(p.user, down, answered, tick, empty)
            if not fit:
                return False
            at[0] = at[0]._replace(user=receive(at[0].user, came, now_ns, p.user))
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
        at[0] = UserRun(user, device, hand, acts)
        if last or tick + 1 >= user.next_frame:
            _note(at[0], p, number, blocks)
            if not last:
                _sent(at, p, tick + 1, now_ns + clock.tick_ns, sent)
    return True


def _note(s: UserRun, p: EndParams, number: int, blocks: Array) -> None:
    """Note a frame that is over, in the row of its packet."""
    user, into = s.user, blocks[number, s.user.packing.number - 1]
    work_j = s.device.against_j, s.device.by_hand_j
    put((float(user.limits.cause), float(user.limits.events), *work_j), into, 0)
    put(port_energies(user.port, user.arrivals, p.user.port), into, 4)
