# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What every controller does at the master's end, in the order of a frame and of a tick; and the
master's end of the plain wave channel.

A member is chosen by the type of its state; ``p`` are the parameters of the port. What has come in
(``arrivals``) belongs to the tick; the strict channel plays its waves out from there.

Every tick on the plain channel (App. B Fig. 1)::

    v      the returning wave, from the hold
    F_m = b xd - sqrt(2b) v_m,   u_m = sqrt(2b) xd - v_m
    u_m_lp, u_tx: the anti-aliasing filter, and every M-th of its outputs

so that F_m xd = (u_m^2 - v_m^2)/2; v_m = v without port filters (:mod:`.port_filters`). Where the
safety limits let another force F through, u_m is shortened until |u_m|^2/2 <= |w + g u_m|^2/2 + F
xd. What even u_m = 0 does not cover, ``deficit_j``, is withheld from later waves. A silent server
is a wave v = 0: F_m = b xd. Equations: docs/theory.md 10.1.
"""

import math
from typing import Any, NamedTuple

from pmwvc_core.law.channel.packet import Packet, Sent
from pmwvc_core.law.family import Family, accounts, opened
from pmwvc_core.law.port.port_filters import answered, filters_up, wave_shortened
from pmwvc_core.law.position.feedback import position_down, position_in, position_send, position_up
from pmwvc_core.law.vectors import Vector, dot, each, minus, zero
from pmwvc_core.law.wave.filter_and_hold import Hold, filter_sample, filter_step, hold, load
from pmwvc_core.law.wave.wave import wave_force, wave_j, wave_u


def _waves(s: Any) -> Any:
    return s.waves


port_measure = Family("port_measure")  # (s, x, xd, p) -> s: motion at a frame start
# (s, arrivals, frame_s, number, held_j, p) -> (s, arrivals, Sent); held_j: what the brake stores
port_send = Family("port_send")
# (s, arrivals, packet, wave, silent, frame_s, p) -> s: the newest packet, of number 0 before the
# first, and its wave, or a silence; once a frame
port_answer = Family("port_answer")
port_tick = Family("port_tick")  # (s, arrivals, x, xd, p) -> (s, arrivals, force wanted [N])
port_passed = Family("port_passed")  # (s, f, p) -> s: with the force that the limits let through
port_signals = Family("port_signals", _waves)  # (s) -> (u_m, u_m_lp, v_m)
# (s, arrivals, p) -> energies since the start [J]: of u_m, sent, received, v_m, and the port's own
port_energies = Family("port_energies")


def known_motion(x: Vector, xd: Vector, last: Vector) -> tuple[Vector, Vector]:
    """Return position and velocity; what is not finite is the last position and no velocity."""
    return each(_finite, (x, last)), each(_finite, (xd, zero(xd)))


def _finite(value: float, otherwise: float) -> float:
    return value if math.isfinite(value) else otherwise


class PlainMaster(NamedTuple):
    """The wave port of a device, with the energies of its waves since the start [J]."""

    hold: Hold
    filter: Any
    filters: Any
    position: Any
    waves: tuple[Vector, Vector, Vector]  # u_m, u_m_lp, v_m [sqrt(W)]
    x: Vector  # [m] last good one
    xd: Vector  # [m/s] of the tick
    f_m: Vector  # [N] wanted in the tick
    u_m_j: float
    u_tx_j: float
    v_rx_j: float
    v_m_j: float
    deficit_j: float  # what force limits gave away


class PlainMasterParams(NamedTuple):
    """Impedance, times [s], and the parameters of the parts."""

    impedance: Any
    tick_s: float
    frame_s: float
    hold_ticks: int
    filter: Any
    filters: Any
    position: Any


@port_measure.member(PlainMaster)
def _measure(s: PlainMaster, x: Vector, xd: Vector, p: PlainMasterParams) -> PlainMaster:
    x, _ = known_motion(x, xd, s.x)
    return s._replace(x=x)


@port_send.member(PlainMaster)
def _send(
    s: PlainMaster, arrivals: Any, frame_s: float, number: int, held_j: float, p: PlainMasterParams
) -> tuple[PlainMaster, Any, Sent]:
    """Send the filter's output after the last tick [sqrt(W)]."""
    after, wave = filter_sample(s.filter, p.filter)
    position, wave = position_send(s.position, wave, number, p.frame_s, p.position)
    u_tx_j = s.u_tx_j + wave_j(wave, p.frame_s)
    s = s._replace(filter=after, position=position, u_tx_j=u_tx_j)
    return s, arrivals, Sent(wave, s.x, -1.0, (), 0)


@port_answer.member(PlainMaster)
def _answer(
    s: PlainMaster, arrivals: Any, packet: Packet, wave: Vector, silent: bool, frame_s: float,
    p: PlainMasterParams,
) -> PlainMaster:  # fmt: skip
    """Take the newest wave; it stands for the frame that begins. A silence is a wave of zero."""
    wave, position = zero(wave) if silent else wave, s.position
    if packet.number > 0:
        position = position_in(position, packet, not silent, p.position)
    v_rx_j = s.v_rx_j + wave_j(wave, p.frame_s)
    return s._replace(hold=load(s.hold, wave), position=position, v_rx_j=v_rx_j)


@port_tick.member(PlainMaster)
def _tick(
    s: PlainMaster, arrivals: Any, x: Vector, xd: Vector, p: PlainMasterParams
) -> tuple[PlainMaster, Any, Vector]:
    x, xd = known_motion(x, xd, s.x)
    held, v = hold(s.hold, p.hold_ticks)
    position, v = position_down(s.position, v, x, 0.0, v, p.position)
    filters, v_m, for_force = answered(s.filters, v, x, xd, p.filters, p.impedance)
    u_m = wave_u(p.impedance, xd, v_m)
    f_m = wave_force(p.impedance, for_force, v_m)
    waves = u_m, s.waves[1], v_m
    s = s._replace(hold=held, filters=filters, position=position, waves=waves, x=x, xd=xd, f_m=f_m)
    return s, arrivals, f_m


@port_passed.member(PlainMaster)
def _applied(s: PlainMaster, f: Vector, p: PlainMasterParams) -> PlainMaster:
    """Pay for the force that was applied [N], then let the wave pass on to the filter."""
    half_s, deficit_j, (u_m, _, v_m) = 0.5 * p.tick_s, s.deficit_j, s.waves
    if f != s.f_m or deficit_j > 0.0:
        # The difference is formed from the two forces, so that equal forces cancel exactly.
        missing = 2.0 * dot(minus(f, s.f_m), s.xd) - deficit_j / half_s
        u_m, v_m, deficit = wave_shortened(s.filters, u_m, v_m, missing, p.impedance)
        deficit_j = deficit * half_s
    filters, on = filters_up(s.filters, u_m, p.filters)
    position = position_up(s.position, on, f, s.xd, p.position)
    after, y = filter_step(s.filter, on, p.filter)
    return s._replace(
        filter=after, filters=filters, position=position, waves=(u_m, y, v_m),
        u_m_j=s.u_m_j + wave_j(u_m, p.tick_s), v_m_j=s.v_m_j + wave_j(v_m, p.tick_s),
        deficit_j=deficit_j,
    )  # fmt: skip


@port_energies.member(PlainMaster)
def _energies(s: PlainMaster, arrivals: Any, p: PlainMasterParams) -> Vector:
    own = s.u_m_j, s.u_tx_j, s.v_rx_j, s.v_m_j
    return own + accounts(s.filters, p.filters) + accounts(s.position, p.position)


@opened.member(PlainMaster)
def opened_port(s: Any) -> Any:
    """Have position feedback make its list."""
    return s._replace(position=opened(s.position))
