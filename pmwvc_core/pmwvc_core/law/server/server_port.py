# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The users around one object: joining, leaving, and one step of the environment from waves to
waves, v_s = u_s - sqrt(2/b) f_s. Joining stores no energy; leaving drops what the springs hold.

An avatar that joined at the face, with its device inside the object, slides to it once there is
room, at most ``SLIDE_M_S``::

    offset <- offset + w h,   x_s <- x_s + w h,   where the avatar is outside before and after

which neither stores nor releases energy (phi(p) = 0 for p <= 0). Equations: docs/theory.md 17.20.
"""

from typing import Any, NamedTuple

from pmwvc_core.law.family import Family
from pmwvc_core.law.motion import Body, BodyLaw, kinetic_j
from pmwvc_core.law.safety.brakes import braked, released_brake, unbraked
from pmwvc_core.law.server.contacts import (
    Avatar,
    attached,
    changed_contact,
    cleared,
    couple,
    detached,
    offset_of,
    slid,
    springs_j,
    touching,
)
from pmwvc_core.law.vectors import Vector, columns, each, minus, plus, shortened, total, zero
from pmwvc_core.law.wave.wave import Rows, wave_j, wave_v

SLIDE_M_S = 0.1


class UserPort(NamedTuple):
    """One user's end: avatar, brake, and what the last step did."""

    avatar: Avatar
    brake: Any  # AvatarBrake, or what a controller without waves keeps of the avatar
    offset: Vector  # [m] avatar minus device, without force
    x_s: Vector  # [m]
    v_s: Vector  # [sqrt(W)]
    u_j: float  # of the waves u_s since the start
    v_j: float  # of the waves v_s
    account_j: float  # sum for the packets if it is kept here; below zero: that of their waves
    extra: Vector  # signals that a controller declares
    visit: int  # counts how often the user joined


class SharedScene(NamedTuple):
    """All users around one object."""

    ports: tuple[UserPort, ...]
    body: Any  # a Body, or a black box
    dissipated_j: float  # heat of contacts and ground, springs let go
    unsettled: int  # steps whose equation was not solved to rounding


class EnvironmentParams(NamedTuple):
    """The coupling, the object, the brakes of an avatar (the strict channel)."""

    coupling: Any
    body: BodyLaw
    brakes: Rows  # 1 for each axis that one holds, else 0


class Came(NamedTuple):
    """What a user brings to a step."""

    wave: Vector  # [sqrt(W)]; without waves the velocity of its device [m/s]
    position: Vector  # [m] of its device
    brakes: bool  # none of its waves come
    received_j: float  # by the sums of its packets, without waves
    extra: Vector  # signals that a controller declares


# (p, s, came) -> s: one step with what each user brings
environment_step = Family("environment_step")


def joined(s: UserPort, position: Vector, body: Body) -> tuple[UserPort, float]:
    """Join at the device's position [m], without force; return what leaving first dropped [J]."""
    s, dropped_j = left(s)
    contact = attached(s.avatar.contact, minus(position, body.x))
    avatar = s.avatar._replace(present=True, contact=contact)
    x_s, v_s = plus(body.x, offset_of(contact)), zero(position)
    s = s._replace(avatar=avatar, offset=minus(x_s, position), x_s=x_s, v_s=v_s, visit=s.visit + 1)
    return s, dropped_j


def left(s: UserPort) -> tuple[UserPort, float]:
    """Leave; return the energy of the springs, which is dropped [J]."""
    a, nothing = s.avatar, zero(s.x_s)
    if not a.present:
        return s, 0.0
    contact, dropped_j = detached(a.contact)
    avatar = Avatar(False, a.impedance, nothing, nothing, nothing, contact, nothing)
    return s._replace(avatar=avatar, brake=released_brake(s.brake), v_s=nothing), dropped_j


def changed_port(
    s: UserPort, stiffness: float, damping: float, impedance: Any
) -> tuple[UserPort, float]:
    """Take contact and impedance over; the springs store what they stored. Return what is lost."""
    a = s.avatar
    contact, lost_j = changed_contact(a.contact, stiffness, damping)
    return s._replace(avatar=a._replace(impedance=impedance, contact=contact)), lost_j


def sum_j(s: UserPort, strict: bool) -> float:
    """Return the energy sum for packets [J]; below zero: that of the waves in them."""
    return s.v_j if strict else s.account_j


@environment_step.member(EnvironmentParams)
def _step(p: EnvironmentParams, s: SharedScene, came: tuple[Came, ...]) -> SharedScene:
    taken, avatars = columns(each(taken_port, (s.ports, came), p))
    avatars, body, lost_j, settled = couple(p.coupling, avatars, s.body, p.body)
    ports, dropped = columns(each(_give, (taken, avatars, came), body, p))
    unsettled = s.unsettled if settled else s.unsettled + 1
    return SharedScene(ports, body, s.dissipated_j + total(lost_j, dropped), unsettled)


def taken_port(s: UserPort, came: Came, p: EnvironmentParams) -> tuple[UserPort, Avatar]:
    """Take the wave of a step; until ``_give`` a braked port is the one behind the brake."""
    a, h = s.avatar, p.body.period_s
    if not a.present:
        return s, a
    brake, b, u = braked(s.brake, a.impedance, came.wave, a.f, came.brakes, h, p.brakes)
    a = a._replace(impedance=b, u=u)
    return s._replace(avatar=a, brake=brake), a


def _give(
    s: UserPort, a: Avatar, came: Came, body: Body, p: EnvironmentParams
) -> tuple[UserPort, float]:
    if not a.present:
        return s, 0.0
    offset, contact, dropped_j, wave, h = s.offset, a.contact, 0.0, came.wave, p.body.period_s
    v_s = wave_v(a.impedance, a.u, a.f)
    brake, impedance, v_s = unbraked(s.brake, a.impedance, wave, a.u, v_s, h, p.brakes)
    if offset != zero(offset):
        way = shortened(minus(zero(offset), offset), h * SLIDE_M_S)
        moved = cleared(contact, way)
        contact, dropped_j = slid(contact, moved)
        offset = plus(offset, moved)
    avatar = a._replace(impedance=impedance, u=wave, contact=contact)
    x_s, u_j, v_j = plus(body.x, offset_of(contact)), wave_j(wave, h), wave_j(v_s, h)
    s = s._replace(avatar=avatar, brake=brake, offset=offset, x_s=x_s, v_s=v_s)
    return s._replace(u_j=s.u_j + u_j, v_j=s.v_j + v_j), dropped_j


# (p, s) -> energies [J]: kinetic, potential, and the accounts of the environment
scene_energies = Family("scene_energies")
port_shown = Family("port_shown")  # (p, s, user) -> PortShown


class PortShown(NamedTuple):
    """A user's port as seen from outside."""

    v_s: Vector  # [sqrt(W)] zero without waves
    touches: bool
    learned: float  # (K T + 2B)/b of what its avatar touches; zero where it learns nothing


def brakes_j(ports: tuple[UserPort, ...]) -> float:
    """Return the heat of all avatars' brakes since the start [J]."""
    total = 0.0
    for i in range(len(ports)):
        total += ports[i].brake.heat_j
    return total


def avatar_of(s: UserPort) -> Avatar:
    """Return the avatar of a port."""
    return s.avatar


@scene_energies.member(EnvironmentParams)
def _energies(p: EnvironmentParams, s: SharedScene) -> Vector:
    return (kinetic_j(s.body, p.body), springs_j(each(avatar_of, (s.ports,))), brakes_j(s.ports))


@port_shown.member(EnvironmentParams)
def _port(p: EnvironmentParams, s: SharedScene, user: int) -> PortShown:
    port = s.ports[user]
    return PortShown(port.v_s, in_touch(port), 0.0)


def in_touch(s: UserPort) -> bool:
    """Tell whether an avatar's contact holds or touches."""
    return s.avatar.present and touching(s.avatar.contact)
