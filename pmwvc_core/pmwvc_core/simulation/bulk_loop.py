# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A whole session as one loop over its ticks, made to be compiled: users, server, and what the
plan of the network says of their packets (:mod:`.plan`).

Per tick: frames that start send their packets; the server steps where it is its turn; every user's
loop and device run. Whatever is to be known of the session is written into arrays.
"""

from typing import Any, NamedTuple

from pmwvc_core.law.arrivals import arrivals_of
from pmwvc_core.law.body import kinetic_j
from pmwvc_core.law.contacts import touching
from pmwvc_core.law.device import device_step
from pmwvc_core.law.forces import hand_force, hand_hold
from pmwvc_core.law.master import port_energies, port_signals
from pmwvc_core.law.packet import Packet
from pmwvc_core.law.sensing import Sample
from pmwvc_core.law.server_port import potential_j
from pmwvc_core.law.server_step import Answer, Guest, Server, server_step
from pmwvc_core.law.user_tick import Tick, User, begin, send, user_tick
from pmwvc_core.law.vectors import Vector, columns, each, squared
from pmwvc_core.numeric import Array, Integers

WAVE, INTEGRAL, POSITION = 0, 1, 2  # vectors of a packet, one behind the other


class Wire(NamedTuple):
    """One direction of a user's link: packets sent, and those accepted."""

    values: Array  # (packets, 3 axes + 3): wave, integral, position, energy, period, time
    flags: Integers  # (packets, 3): short, waits, anew
    look: Integers  # (accepted,) tick at which it is taken in,
    which: Integers  # and which one it is, from 0
    fresh: Integers
    lost: Integers
    longest: float  # wave that its receiver takes [sqrt(W)]


class Line(NamedTuple):
    """The links of a user, and what its loop leaves behind."""

    up: Wire
    down: Wire
    signals: Array  # (8, ticks, axes)
    blocks: Array  # (blocks, energies and cause)


class End(NamedTuple):
    """A user with device and hand; how far its packets and blocks are."""

    user: User
    device: Any
    hand: Any
    acts: bool
    sent: int
    taken: int
    blocks: int


class EndParams(NamedTuple):
    """Their parameters."""

    user: Any
    device: Any
    hand: Any


class Steps(NamedTuple):
    """What the steps of the server leave behind."""

    signals: Array  # (2 + 5 users, steps, axes)
    energies: Array  # (steps, 4 + 4 users)
    presence: Integers  # (steps, users)


class Clock(NamedTuple):
    """Ticks of the session, their length, and the server's steps in them."""

    ticks: int
    tick_ns: int
    period_ticks: int
    axes: tuple[int, ...]  # numbers of the axes: 0, 1 ...


def session(
    ends: tuple[End, ...], server: Server, lines: tuple[Line, ...], steps: Steps,
    users: tuple[EndParams, ...], p: Any, clock: Clock,
) -> bool:  # fmt: skip
    """Run a session; tell whether all went by the plan."""
    nothing = each(_zero, (clock.axes,))
    ends = each(_opened_end, (ends,), nothing)
    server = Server(
        each(_opened_guest, (server.guests,), nothing), server.environment, server.task_s
    )
    taken, posted = each(_none, (lines,)), each(_none, (lines,))
    no_packets = [ends[0].user.newest]
    no_packets.pop()
    step, next_step = 0, 0
    for tick in range(clock.ticks):
        now_ns = tick * clock.tick_ns
        ends = each(_sent, (ends, users, lines), tick, now_ns)
        if tick == next_step:
            packets, taken, fit = columns(
                each(_arrived, (_ups(lines), taken), tick, clock, no_packets)
            )
            if not all_of(fit):
                return False
            server, answers = server_step(server, now_ns, packets, 0.0, p)
            posted = each(_posted, (_downs(lines), answers, posted))
            _note_step(steps, step, server, p)
            step, next_step = step + 1, next_step + clock.period_ticks
        ends, fit = columns(each(_ran, (ends, users, lines), tick, now_ns, clock, no_packets))
        if not all_of(fit):
            return False
    return True


def all_of(flags: tuple[bool, ...]) -> bool:
    """Tell whether all of them are set."""
    every = True
    for i in range(len(flags)):
        every = every and flags[i]
    return every


def _zero(axis: int) -> float:
    return 0.0


def _none(line: Line) -> int:
    return 0


def _up(line: Line) -> Wire:
    return line.up


def _down(line: Line) -> Wire:
    return line.down


def _ups(lines: tuple[Line, ...]) -> Any:
    return each(_up, (lines,))


def _downs(lines: tuple[Line, ...]) -> Any:
    return each(_down, (lines,))


def _opened_end(s: End, nothing: Vector) -> End:
    u = s.user
    user = User(u.frames, u.frame_s, u.packing, arrivals_of(u.arrivals, nothing), u.newest,
                u.servers, u.port, u.limits, u.sensing, u.due, u.coupled)  # fmt: skip
    return End(user, s.device, s.hand, s.acts, s.sent, s.taken, s.blocks)


def _opened_guest(s: Guest, nothing: Vector) -> Guest:
    return Guest(s.presence, s.anew, arrivals_of(s.arrivals, nothing), s.packing)


def _read(s: Any, now_ns: int) -> Sample:
    return Sample(s.read_x, s.read_xd, True, now_ns)


def _sent(s: End, p: EndParams, line: Line, tick: int, now_ns: int) -> End:
    """Start a frame, if it is time."""
    if tick < s.user.frames.next_frame:
        return s
    user, packet, _ = send(s.user, now_ns, _read(s.device, now_ns), p.user)
    _write_packet(line.up, s.sent, packet)
    return End(begin(user, tick, p.user), s.device, s.hand, s.acts, s.sent + 1, s.taken, s.blocks)


def _posted(wire: Wire, answer: Answer, posted: int) -> int:
    if not answer.sends:
        return posted
    _write_packet(wire, posted, answer.packet)
    return posted + 1


def _write_packet(wire: Wire, row: int, packet: Packet) -> None:
    n = len(packet.wave)
    for i in range(n):
        wire.values[row, i] = packet.wave[i]
        wire.values[row, n + i] = packet.integral[i]
        wire.values[row, 2 * n + i] = packet.position[i]
    wire.values[row, 3 * n] = packet.energy_j
    wire.values[row, 3 * n + 1] = packet.period_s
    wire.values[row, 3 * n + 2] = packet.sent_ns
    wire.flags[row, 0] = packet.short
    wire.flags[row, 1] = packet.waits
    wire.flags[row, 2] = packet.anew


def _element(axis: int, values: Array, row: int, first: int) -> float:
    return float(values[row, first + axis])


def _arrived(
    wire: Wire, taken: int, tick: int, clock: Clock, no_packets: list[Packet]
) -> tuple[list[Packet], int, bool]:
    """Return the packets that are taken in with a tick, and whether all are fit."""
    if taken >= len(wire.look) or wire.look[taken] > tick:
        return no_packets, taken, True
    packets, fit, n = no_packets.copy(), True, len(clock.axes)
    while taken < len(wire.look) and wire.look[taken] <= tick:
        row = wire.which[taken]
        wave = each(_element, (clock.axes,), wire.values, row, WAVE * n)
        integral = each(_element, (clock.axes,), wire.values, row, INTEGRAL * n)
        position = each(_element, (clock.axes,), wire.values, row, POSITION * n)
        energy_j, period_s = wire.values[row, 3 * n], wire.values[row, 3 * n + 1]
        sent_ns = int(wire.values[row, 3 * n + 2])
        fit = fit and squared(wave) <= wire.longest**2  # not so where it is no number
        packets.append(Packet(
            row + 1, sent_ns, period_s, wave, integral, energy_j, position,
            wire.flags[row, 0] != 0, wire.flags[row, 1] != 0, wire.flags[row, 2] != 0, False, (),
            wire.fresh[taken] != 0, wire.lost[taken],
        ))  # fmt: skip
        taken += 1
    return packets, taken, fit


def _ran(
    s: End, p: EndParams, line: Line, tick: int, now_ns: int, clock: Clock,
    no_packets: list[Packet],
) -> tuple[End, bool]:  # fmt: skip
    """Run a tick of a user's loop and device."""
    device, acts = s.device, s.acts or s.user.limits.fading.ready
    if acts:  # the hand is in touch with the device itself, not with its encoder
        hand, f_h = hand_force(s.hand, device.x, device.xd, p.hand)
    else:
        hand, f_h = hand_hold(s.hand, device.x, p.hand)
    packets, taken, fit = _arrived(line.down, s.taken, tick, clock, no_packets)
    sample = _read(device, now_ns)
    user, out = user_tick(s.user, tick, now_ns, sample, packets, p.user)
    _note_tick(line.signals, tick, sample, f_h, out, port_signals(user.port))
    device, _, _ = device_step(device, f_h, out.f, p.device)
    blocks = s.blocks
    if tick + 1 >= min(user.frames.next_frame, clock.ticks):
        _note_block(line.blocks, blocks, user, device)
        blocks += 1
    return End(user, device, hand, acts, s.sent, taken, blocks), fit


def _note_tick(rows: Array, tick: int, sample: Sample, f_h: Vector, out: Tick, waves: Any) -> None:
    for i in range(len(f_h)):
        rows[0, tick, i] = sample.x[i]
        rows[1, tick, i] = sample.xd[i]
        rows[2, tick, i] = f_h[i]
        rows[3, tick, i] = out.f_m[i]
        rows[4, tick, i] = out.f[i]
        rows[5, tick, i] = waves[0][i]
        rows[6, tick, i] = waves[1][i]
        rows[7, tick, i] = waves[2][i]


def _note_block(rows: Array, block: int, user: User, device: Any) -> None:
    rows[block, 0] = user.limits.cause
    rows[block, 1] = user.limits.interventions.events
    rows[block, 2] = device.against_j
    rows[block, 3] = device.by_hand_j
    energies = port_energies(user.port, user.arrivals)
    for i in range(len(energies)):
        rows[block, 4 + i] = energies[i]


def _note_step(steps: Steps, row: int, server: Server, p: Any) -> None:
    at, e = server.environment, steps.energies
    e[row, 0] = kinetic_j(at.body, p.environment.body)
    e[row, 1] = potential_j(at)
    e[row, 2] = at.dissipated_j
    e[row, 3] = server.task_s
    for i in range(len(at.body.x)):
        steps.signals[0, row, i] = at.body.x[i]
        steps.signals[1, row, i] = at.body.xd[i]
    for k in range(len(at.ports)):
        port = at.ports[k]
        steps.presence[row, k] = server.guests[k].presence
        e[row, 4 + 4 * k] = port.sums.u_j
        e[row, 5 + 4 * k] = port.sums.v_j
        e[row, 6 + 4 * k] = port.avatar.present and touching(port.avatar.contact)
        e[row, 7 + 4 * k] = port.brake.heat_j
        for i in range(len(port.x_s)):
            steps.signals[2 + 5 * k, row, i] = port.x_s[i]
            steps.signals[3 + 5 * k, row, i] = port.avatar.xd[i]
            steps.signals[4 + 5 * k, row, i] = port.avatar.f[i]
            steps.signals[5 + 5 * k, row, i] = port.avatar.u[i]
            steps.signals[6 + 5 * k, row, i] = port.v_s[i]
