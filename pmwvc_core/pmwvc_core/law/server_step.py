# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The whole step of the server, in order.

::

    what has come     packets of every user: a first one, or one of a new life, joins the user; a
                      last one, or a long silence, takes the user out
    the environment   one wave of each user in, avatars and object one step on, waves out
    the answers       to those who are present
    the target        where the object is to be brought, once all have been together
"""

import math
from typing import Any, NamedTuple

from pmwvc_core.law.channel.arrivals import anew, arrive, idle, news, raised, spare, waits, wave_of
from pmwvc_core.law.channel.packet import Deadband, Packet, Packing, Sent, no_packet, pack, silence
from pmwvc_core.law.motion import Body
from pmwvc_core.law.server.server_port import (
    Came,
    SharedScene,
    UserPort,
    environment_step,
    joined,
    left,
    sum_j,
)
from pmwvc_core.law.vectors import Vector, columns, each, filled, minus, scaled, total, zero
from pmwvc_core.law.wave.following import Following, followed
from pmwvc_core.law.wave.wave import firmer

ABSENT, JOINING, COUPLED, DAMPING = 0, 1, 2, 3


class Guest(NamedTuple):
    """A user as the server has it."""

    presence: int
    anew: bool  # flips whenever the avatar is placed anew
    arrivals: Any
    packing: Packing
    extra: Vector  # signals beside the wave, of the newest packet
    following: Following


class GuestParams(NamedTuple):
    """Parameters of what comes from a user and goes to it."""

    arrivals: Any
    packing: Deadband
    most: float  # n


class Server(NamedTuple):
    """All users, the environment between them, and the time of the task [s]."""

    guests: tuple[Guest, ...]
    environment: SharedScene
    task_s: float  # infinite until all have been together, then from minus a soft start on


class ServerStepParams(NamedTuple):
    """Parameters of the parts; when a silent user leaves, and the soft start of the task [s]."""

    guests: tuple[GuestParams, ...]
    environment: Any
    period_s: float
    release_s: float
    soft_start_s: float


def server_step(
    s: Server, now_ns: int, packets: tuple[list[Packet], ...], missed_s: float, p: ServerStepParams
) -> tuple[Server, tuple[tuple[Packet, bool], ...]]:
    """Take in what has come, advance the environment by its period; return whom to send what."""
    before = s.environment
    guests, ports, came, lost = columns(
        each(_come, (s.guests, before.ports, packets, p.guests), now_ns, missed_s, before.body, p)
    )
    dissipated_j = total(before.dissipated_j, lost)
    before = before._replace(ports=ports, dissipated_j=dissipated_j)
    after = environment_step(p.environment, before, came)
    rows = guests, after.ports, p.guests
    guests, ports, answers = columns(each(_gone, rows, now_ns, p.period_s))
    together = True
    for i in range(len(guests)):
        together = together and guests[i].presence == COUPLED
    task_s = s.task_s
    if task_s < math.inf:
        task_s += p.period_s
    elif together:
        task_s = -p.soft_start_s
    return Server(guests, after._replace(ports=ports), task_s), answers


def _come(
    s: Guest, port: UserPort, packets: list[Packet], q: GuestParams, now_ns: int, missed_s: float,
    body: Body, p: ServerStepParams,
) -> tuple[Guest, UserPort, Came, float]:  # fmt: skip
    """Take a user's packets in; return what it brings to the step, and the energy dropped [J]."""
    presence, flips, arrivals, lost_j, extra = s.presence, s.anew, s.arrivals, 0.0, s.extra
    following = followed(s.following, port.avatar.f, p.period_s, q.most)
    arrivals = raised(arrivals, following.ratio)
    there, brakes, a = presence != ABSENT, False, port.avatar
    if following.ratio != s.following.ratio:
        n = filled(a.u, following.ratio / s.following.ratio)
        port = port._replace(avatar=a._replace(impedance=firmer(a.impedance, n)))
    for packet in packets:
        arrivals, extra = arrive(arrivals, packet, now_ns, q.arrivals), packet.extra
        if packet.leaves:
            port, dropped_j = left(port)
            presence, lost_j = ABSENT, lost_j + dropped_j
        elif packet.fresh or presence == ABSENT:
            port, dropped_j = joined(port, packet.position, body)
            arrivals, flips = anew(arrivals), not flips
            presence, lost_j = JOINING, lost_j + dropped_j
    if missed_s > 0.0 and there:
        arrivals = idle(arrivals, missed_s)
    arrivals, wave = wave_of(arrivals, p.period_s, q.arrivals)
    silence_s, silent, unreceived = silence(arrivals.silence, now_ns)
    if silent and not q.arrivals.plays_on:
        wave = zero(wave)
    if presence != ABSENT:
        if silence_s > p.release_s:
            port, dropped_j = left(port)
            presence, lost_j = ABSENT, lost_j + dropped_j
        else:
            presence, brakes = COUPLED, unreceived or waits(arrivals)
            if unreceived or (silent and (brakes or not q.arrivals.plays_on)):
                presence = DAMPING
    wave = scaled(wave, math.sqrt(following.ratio))
    came = Came(wave, arrivals.position, brakes, arrivals.received_j, extra)
    return Guest(presence, flips, arrivals, s.packing, extra, following), port, came, lost_j


def _gone(
    s: Guest, port: UserPort, q: GuestParams, now_ns: int, period_s: float
) -> tuple[Guest, UserPort, tuple[Packet, bool]]:
    """Answer a user; energy that it lacks and its wave does not need here goes back to it."""
    arrivals, packing = s.arrivals, s.packing
    if s.presence == ABSENT:
        return s, port, (no_packet(zero(port.x_s), port.extra), False)
    arrivals, passed_j = spare(arrivals, period_s, q.arrivals)
    port = port._replace(u_j=port.u_j + passed_j, v_j=port.v_j + passed_j)
    wave = scaled(port.v_s, 1.0 / math.sqrt(s.following.ratio))
    x, own_j = minus(port.x_s, port.offset), sum_j(port, q.arrivals.plays_on)
    sent = Sent(wave, x, own_j, port.extra, int(s.following.level))
    packing, packet, sends = pack(
        packing, sent, period_s, now_ns, news(arrivals, q.arrivals), s.anew, False,
        arrivals.silence.number, 0, q.packing,
    )  # fmt: skip
    return s._replace(arrivals=arrivals, packing=packing), port, (packet, sends)
