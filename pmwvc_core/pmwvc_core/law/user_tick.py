# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The whole tick of a user's force loop, in order.

::

    first tick of a frame   the packet leaves, with the wave of the ticks before; a frame begins
    every tick              packets that have come; motion -> port -> limits -> force
    answer tick             the newest wave to the port, once a frame

Frames begin at the multiples of their length M, so that both ends keep their phases: where M
changes, or ticks were skipped, a frame lasts to the next multiple. The caller sends and begins
frames (``send``, ``begin``). Without a sample the position stays the last one, with no velocity.
"""

import math
from typing import Any, NamedTuple

from pmwvc_core.law.channel.arrivals import answer_of, arrive, idle, news, waits
from pmwvc_core.law.channel.packet import Deadband, Packet, Packing, pack, silence
from pmwvc_core.law.port.master import port_answer, port_measure, port_passed, port_send, port_tick
from pmwvc_core.law.safety.brakes import brake_stored_j
from pmwvc_core.law.safety.limits import FADE_S, Limits, LimitsParams, limits, limits_restart
from pmwvc_core.law.vectors import Vector, zero

LATE_NS = 5_000_000  # a sample older than this is counted
STALE_NS = 20_000_000  # one older than this is none: the device is silent
NEVER_NS = -(1 << 62)


class Sample(NamedTuple):
    """What a device says at a tick."""

    x: Vector  # [m]
    xd: Vector  # [m/s]
    valid: bool  # position and velocity can be trusted
    measured_ns: int  # when; NEVER_NS where nothing new came since the last sample
    outside: bool  # the device is beyond its workspace


def age_ns(sample: Sample, measured_ns: int, now_ns: int) -> float:
    """Return how old a sample is, or the newest before, of ``measured_ns``; infinite: none."""
    old = now_ns - max(measured_ns, sample.measured_ns)
    return float(old) if sample.valid and old >= 0 else math.inf


class ForceLoop(NamedTuple):
    """A user's force loop."""

    next_frame: int  # tick that starts it
    next_answer: int  # tick that takes it
    rate_drop: int  # on whose grid the present frame lies
    frame_s: float  # length of the present frame
    packing: Packing
    arrivals: Any
    newest: Packet
    servers: int  # that were ever heard: one that starts again is another one
    port: Any
    limits: Limits
    x: Vector  # [m] of the last good sample
    measured_ns: int  # when the newest sample was
    late: int  # ticks with an old sample, or none
    due: int  # tick after the last one that ran
    coupled: bool  # an answer came when the force had been let through in full


class UserParams(NamedTuple):
    """Parameters of a force loop and its parts."""

    rate_drop: int  # M, ticks of a frame
    answer_tick: int  # which of them takes the answer
    tick_s: float
    packing: Deadband
    arrivals: Any
    port: Any
    limits: LimitsParams


def send(
    s: ForceLoop, now_ns: int, sample: Sample, leaves: bool, p: UserParams
) -> tuple[ForceLoop, Packet, bool]:
    """Return the packet of the frame that ends, and whether it is sent; the last one is."""
    port, arrivals, number = s.port, s.arrivals, s.packing.number + 1
    if age_ns(sample, s.measured_ns, now_ns) <= STALE_NS:
        port = port_measure(port, sample.x, sample.xd, p.port)
    held_j = 0.0
    for i in range(len(s.limits.parts)):
        held_j += brake_stored_j(s.limits.parts[i].brake, p.limits.brake_stiffness)
    port, arrivals, sent = port_send(port, arrivals, s.frame_s, number, held_j, p.port)
    packing, packet, sends = pack(
        s.packing, sent, s.frame_s, now_ns, news(arrivals, p.arrivals), False, leaves,
        arrivals.silence.number, s.limits.events, p.packing,
    )  # fmt: skip
    return s._replace(packing=packing, arrivals=arrivals, port=port), packet, sends


def next_on_grid(now: int, every: int, phase: int) -> int:
    """Return the first point of a grid of frames or steps after a time, in ticks or in ns."""
    return now + every - (now - phase) % every


def begin(s: ForceLoop, tick: int, p: UserParams) -> ForceLoop:
    """Begin a frame with a tick."""
    of_frame, ends = tick - tick % s.rate_drop, next_on_grid(tick, p.rate_drop, 0)
    return s._replace(
        next_frame=ends, next_answer=min(of_frame + p.answer_tick, ends - 1),
        rate_drop=p.rate_drop, frame_s=(ends - of_frame) * p.tick_s,
    )  # fmt: skip


def receive(s: ForceLoop, packets: list[Packet], now_ns: int, p: UserParams) -> ForceLoop:
    """Take packets in, in the order of their arrival."""
    arrivals, newest, servers, limit = s.arrivals, s.newest, s.servers, s.limits
    for packet in packets:
        arrivals, newest = arrive(arrivals, packet, now_ns, p.arrivals), packet
        if packet.fresh:
            limit = limits_restart(limit) if servers > 0 else limit
            servers += 1
    return s._replace(arrivals=arrivals, newest=newest, servers=servers, limits=limit)


def user_tick(
    s: ForceLoop, tick: int, now_ns: int, sample: Sample, packets: list[Packet] | None,
    p: UserParams,
) -> tuple[ForceLoop, Vector, Vector]:  # fmt: skip
    """Run a tick of a frame that has begun; return the forces wanted and for the device [N]."""
    if (tick - s.due) * p.tick_s > FADE_S:
        s = s._replace(limits=s.limits._replace(before=s.limits.f, left=1.0))
    if packets is not None:
        s = receive(s, packets, now_ns, p)
    next_answer, arrivals, known_server = s.next_answer, s.arrivals, s.servers > 0
    port, limit, coupled = s.port, s.limits, s.coupled
    silence_s, silent, unreceived = silence(arrivals.silence, now_ns)
    if tick >= next_answer:
        next_answer += p.rate_drop
        if known_server:
            least_s = max(p.limits.timeout_s, arrivals.silence.limit_ns / 1e9)
            limit = limit._replace(silence_s=least_s)
        arrivals, wave = answer_of(arrivals, s.frame_s, p.arrivals)
        port = port_answer(port, arrivals, s.newest, wave, silent, s.frame_s, p.port)
        coupled = coupled or limit.ready
    if tick > s.due:
        arrivals = idle(arrivals, (tick - s.due) * p.tick_s)
    age = age_ns(sample, s.measured_ns, now_ns)
    known = age <= STALE_NS
    x, xd = (sample.x, sample.xd) if known else (s.x, zero(s.x))
    port, arrivals, f_m = port_tick(port, arrivals, x, xd, p.port)
    interrupted = unreceived or waits(arrivals)
    limit, f = limits(
        limit, f_m, x, s.x, xd, silence_s, known_server, known, interrupted, unreceived,
        sample.outside, p.limits,
    )  # fmt: skip
    port = port_passed(port, f, p.port)
    s = s._replace(
        next_answer=next_answer, arrivals=arrivals, port=port, limits=limit, x=x,
        measured_ns=max(s.measured_ns, sample.measured_ns), late=s.late + (age > LATE_NS),
        due=tick + 1, coupled=coupled,
    )  # fmt: skip
    return s, f_m, f
