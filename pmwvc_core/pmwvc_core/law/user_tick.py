# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The whole tick of a user's force loop, in order.

::

    first tick of a frame   the packet leaves, with the wave of the ticks before; a frame begins
    every tick              packets that have come; motion -> port -> limits -> force
    answer tick             the newest wave to the port, once a frame

Frames begin at the multiples of their length M. Where M changes, or ticks were skipped, the frame
that begins is as long as it takes to the next multiple, so that both ends keep their phases. A
frame whose first ticks were skipped starts, and takes its answer, with the first tick that runs.

A caller whose answers come within the same instant starts the frame itself, before the tick; and
one that changes parameters sends, changes, and begins the frame (``send``, ``begin``).
"""

from typing import Any, NamedTuple

from pmwvc_core.law.channel.arrivals import answer_of, arrive, interrupted, lacks, missed, waits
from pmwvc_core.law.channel.packet import About, Packet, Packing, PackingParams, pack
from pmwvc_core.law.channel.silence import is_silent, is_unreceived, silence_s
from pmwvc_core.law.port.master import (
    port_answer,
    port_applied,
    port_measure,
    port_packet,
    port_send,
    port_tick,
)
from pmwvc_core.law.port.sensing import STALE_NS, Sample, Sensing, age_ns, sensed
from pmwvc_core.law.safety.brakes import brake_stored_j
from pmwvc_core.law.safety.limits import (
    Limits,
    LimitsInput,
    LimitsParams,
    expect,
    limits,
    limits_restart,
)
from pmwvc_core.law.vectors import Vector


class Frames(NamedTuple):
    """Ticks that start the next frame and take the next answer; length on whose grid it lies."""

    next_frame: int
    next_answer: int
    rate_drop: int


class FrameParams(NamedTuple):
    """Ticks of a frame, M; which of them takes the answer; period of a tick [s]."""

    rate_drop: int
    answer_tick: int
    tick_s: float


class User(NamedTuple):
    """A user's force loop."""

    frames: Frames
    frame_s: float  # length of the present frame
    packing: Packing
    arrivals: Any
    newest: Packet
    servers: int  # that were ever heard: one that starts again is another one
    port: Any
    limits: Limits
    sensing: Sensing
    due: int  # tick after the last one that ran
    coupled: bool  # an answer came when the force had been let through in full


class UserParams(NamedTuple):
    """Parameters of the parts of a force loop."""

    frames: FrameParams
    packing: PackingParams
    arrivals: Any
    port: Any
    limits: LimitsParams


class Tick(NamedTuple):
    """Motion as the loop had it, force wanted and force for the device [N]."""

    f_m: Vector
    f: Vector


def send(
    s: User, now_ns: int, sample: Sample, leaves: bool, p: UserParams
) -> tuple[User, Packet, bool]:
    """Return the packet of the frame that ends, and whether it is sent; the last one is."""
    port, arrivals, number = s.port, s.arrivals, s.packing.number + 1
    if age_ns(s.sensing, sample, now_ns) <= STALE_NS:
        port = port_measure(port, sample.x, sample.xd, p.port)
    held_j = brake_stored_j(s.limits.brake, p.limits.brake_stiffness)
    port, arrivals, sent = port_send(port, arrivals, s.frame_s, number, held_j, p.port)
    about = About(now_ns, lacks(arrivals), waits(arrivals), False, leaves,
                  arrivals.silence.number, s.limits.events)  # fmt: skip
    packing, packet, sends = pack(s.packing, sent, s.frame_s, about, p.packing)
    return s._replace(packing=packing, arrivals=arrivals, port=port), packet, sends


def next_on_grid(now: int, every: int, phase: int) -> int:
    """Return the first point of a grid of frames or steps after a time, in ticks or in ns."""
    return now + every - (now - phase) % every


def begin(s: User, tick: int, p: UserParams) -> User:
    """Begin a frame with a tick."""
    every, of_frame = p.frames.rate_drop, tick - tick % s.frames.rate_drop
    ends = next_on_grid(tick, every, 0)
    frames = Frames(ends, min(of_frame + p.frames.answer_tick, ends - 1), every)
    return s._replace(frames=frames, frame_s=(ends - of_frame) * p.frames.tick_s)


def receive(s: User, packets: list[Packet], now_ns: int, p: UserParams) -> User:
    """Take packets in, in the order of their arrival."""
    arrivals, newest, servers, limit = s.arrivals, s.newest, s.servers, s.limits
    for packet in packets:
        arrivals, newest = arrive(arrivals, packet, now_ns, p.arrivals), packet
        if packet.fresh:
            limit = limits_restart(limit) if servers > 0 else limit
            servers += 1
    return s._replace(arrivals=arrivals, newest=newest, servers=servers, limits=limit)


def user_tick(
    s: User, tick: int, now_ns: int, sample: Sample, packets: list[Packet] | None, p: UserParams
) -> tuple[User, Tick]:
    """Run one tick of a frame that has begun; ``packets`` are None where none came."""
    if packets is not None:
        s = receive(s, packets, now_ns, p)
    frames, arrivals, servers = s.frames, s.arrivals, s.servers
    port, limit, coupled = s.port, s.limits, s.coupled
    if tick >= frames.next_answer:
        frames = frames._replace(next_answer=frames.next_answer + p.frames.rate_drop)
        if servers > 0:
            port = port_packet(port, arrivals, s.newest, p.port)
            limit = expect(limit, arrivals.silence.limit_ns / 1e9, p.limits)
        arrivals, wave = answer_of(arrivals, s.frame_s, p.arrivals)
        port = port_answer(port, wave, is_silent(arrivals.silence, now_ns), s.frame_s, p.port)
        coupled = coupled or limit.fading.ready
    if tick > s.due:
        arrivals = missed(arrivals, (tick - s.due) * p.frames.tick_s)
    sensing, x, xd, known = sensed(s.sensing, sample, now_ns)
    port, arrivals, f_m = port_tick(port, arrivals, x, xd, p.port)
    silent_s, brakes = silence_s(arrivals.silence, now_ns), interrupted(arrivals, now_ns)
    unreceived = is_unreceived(arrivals.silence, now_ns)
    asked = LimitsInput(f_m, x, xd, silent_s, servers > 0, known, brakes, unreceived)
    limit, f = limits(limit, asked, p.limits)
    port = port_applied(port, f, p.port)
    s = s._replace(
        frames=frames, arrivals=arrivals, port=port, limits=limit, sensing=sensing, due=tick + 1,
        coupled=coupled,
    )  # fmt: skip
    return s, Tick(f_m, f)
