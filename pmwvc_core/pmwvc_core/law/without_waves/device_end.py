# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The device's end of all controllers without waves.

It sends where the device is and how fast it moves, and counts what flowed from the hand into the
controller and back: the force that the limits let through times the velocity at the tick. The wave
signals are zero. What a controller adds is chosen by the type of its state.
"""

from typing import Any, NamedTuple

from pmwvc_core.law.channel.arrivals import received_j
from pmwvc_core.law.channel.packet import Packet, Sent
from pmwvc_core.law.family import Family, no_accounts, same
from pmwvc_core.law.port import master
from pmwvc_core.law.port.sensing import known_motion
from pmwvc_core.law.vectors import Vector, dot, zero


class DeviceEnd(NamedTuple):
    """A master's end without waves."""

    x: Vector  # [m] last measured
    xd: Vector  # [m/s]
    law: Any
    given_j: float  # from the device into the controller
    taken_j: float  # and back


class DeviceEndParams(NamedTuple):
    """Period of a tick [s], and the parameters of the controller."""

    tick_s: float
    law: Any


def _no_energy(law: Any, p: DeviceEndParams) -> tuple[Any, float]:
    return law, -1.0


# (law, before, x, xd, p) -> law: moved since the last tick, when the end was that
device_moved = Family("device_moved", same)
# (law, p) -> (law, running sum of energy; below zero: none)
device_sends = Family("device_sends", _no_energy)
# (law, packet, received_j, p) -> law: once a frame
device_receives = Family("device_receives", same)
# (law, wave, silent, x, p) -> law: what the newest packet carries, or let go
device_answer = Family("device_answer")
device_force = Family("device_force")  # (law, x, xd, p) -> (law, force wanted [N])
# (state at either end) -> accounts [J]
controller_energies = Family("controller_energies", no_accounts)
device_applied = Family("device_applied", same)  # (law, f, p) -> law: the force let through [N]


def resting_end(law: Any, axes: int) -> DeviceEnd:
    """Return a device's end at rest, with the state of its controller."""
    nothing = (0.0,) * axes
    return DeviceEnd(nothing, nothing, law, 0.0, 0.0)


@master.port_measure.member(DeviceEnd)
def _measure(s: DeviceEnd, x: Vector, xd: Vector, p: DeviceEndParams) -> DeviceEnd:
    x, xd = known_motion(x, xd, s.x)
    return s._replace(x=x, xd=xd, law=device_moved(s.law, s, x, xd, p))


@master.port_send.member(DeviceEnd)
def _send(
    s: DeviceEnd, arrivals: Any, frame_s: float, number: int, held_j: float, p: DeviceEndParams
) -> tuple[DeviceEnd, Any, Sent]:
    law, energy_j = device_sends(s.law, p)
    return s._replace(law=law), arrivals, Sent(s.xd, s.x, energy_j, ())


@master.port_packet.member(DeviceEnd)
def _packet(s: DeviceEnd, arrivals: Any, packet: Packet, p: DeviceEndParams) -> DeviceEnd:
    return s._replace(law=device_receives(s.law, packet, received_j(arrivals), p))


@master.port_answer.member(DeviceEnd)
def _answer(
    s: DeviceEnd, wave: Vector, silent: bool, frame_s: float, p: DeviceEndParams
) -> DeviceEnd:
    return s._replace(law=device_answer(s.law, wave, silent, s.x, p))


@master.port_tick.member(DeviceEnd)
def _tick(
    s: DeviceEnd, arrivals: Any, x: Vector, xd: Vector, p: DeviceEndParams
) -> tuple[DeviceEnd, Any, Vector]:
    s = _measure(s, x, xd, p)
    law, f = device_force(s.law, s.x, s.xd, p)
    return s._replace(law=law), arrivals, f


@master.port_applied.member(DeviceEnd)
def _applied(s: DeviceEnd, f: Vector, p: DeviceEndParams) -> DeviceEnd:
    energy_j = p.tick_s * dot(f, s.xd)
    given_j, taken_j = s.given_j + max(energy_j, 0.0), s.taken_j + max(-energy_j, 0.0)
    return DeviceEnd(s.x, s.xd, device_applied(s.law, f, p), given_j, taken_j)


@master.port_signals.member(DeviceEnd)
def _signals(s: DeviceEnd) -> tuple[Vector, Vector, Vector]:
    nothing = zero(s.x)
    return nothing, nothing, nothing


@master.port_energies.member(DeviceEnd)
def _energies(s: DeviceEnd, arrivals: Any, p: DeviceEndParams) -> Vector:
    of_port: Vector = (s.given_j, s.given_j, s.taken_j, s.taken_j)
    return of_port + controller_energies(s.law)
