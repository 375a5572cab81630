# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The server's end of all controllers without waves.

The object moves exactly under the last forces held; then every avatar meets it, each by itself.
``u_j`` is the flow to the avatar, ``v_j`` the flow back, both from f_s xd_s. An avatar
goes along with the device (``direct``, ``tdpa``; the force goes back), or hangs on spring and
damper (``virtual_coupling``, ``pspm``; its position goes back, in the device's frame).
"""

from typing import Any, NamedTuple

from pmwvc_core.law.family import Family
from pmwvc_core.law.server.avatar import Avatar
from pmwvc_core.law.server.body import Body, BodyLaw, kinetic_j
from pmwvc_core.law.server.contacts import (
    Contact,
    contact_heat,
    contact_unwrapped,
    offset_of,
    slid,
)
from pmwvc_core.law.server.sampled import object_pushed
from pmwvc_core.law.server.server_port import (
    Environment,
    PortShown,
    UserPort,
    avatar_of,
    environment_energies,
    environment_step,
    in_touch,
    port_shown,
    potential_j,
)
from pmwvc_core.law.vectors import Vector, columns, dot, each, minus, plus, scaled, total, zero
from pmwvc_core.law.wave.wave import loaded_axis
from pmwvc_core.law.without_waves.device_end import controller_energies


class AvatarEndParams(NamedTuple):
    """The laws of the users, the object, whether the avatars hang on springs."""

    laws: tuple[Any, ...]
    body: BodyLaw
    sprung: bool


class Reported(NamedTuple):
    """What is known of a device, in the avatar's frame."""

    position: Vector  # [m]
    velocity: Vector  # [m/s]
    received_j: float  # running sum of what its packets brought


class Met(NamedTuple):
    """An avatar after its step."""

    kept: Any
    xd: Vector  # [m/s]
    f: Vector  # [N] on the object
    contact: Contact
    rate: Vector  # [m/s] relative velocity that the contact's damper had
    sent_j: float  # running sum for the packets; below zero: none
    lost_j: float


# (law, port, avatar, report, body, h) -> Met: move an avatar and form its force
meet = Family("meet")


@environment_step.member(AvatarEndParams)
def _step(p: AvatarEndParams, s: Environment, came: tuple[Any, ...]) -> Environment:
    avatars, body, lost_j = object_pushed(each(avatar_of, (s.ports,)), s.body, p.body)
    rows = (s.ports, avatars, came, p.laws)
    ports, lost = columns(each(_meet, rows, body, p.body.period_s, p.sprung))
    return Environment(ports, body, s.dissipated_j + total(lost_j, lost), s.unsettled)


def _meet(
    s: UserPort, a: Avatar, came: Any, law: Any, body: Body, h: float, sprung: bool
) -> tuple[UserPort, float]:
    if not a.present:
        return s, 0.0
    report = Reported(plus(came.position, s.offset), came.wave, came.received_j)
    met = meet(law, s, a, report, body, h)
    avatar = a._replace(xd=met.xd, f=met.f, contact=met.contact)
    x_s = plus(body.x, offset_of(met.contact))
    answer = minus(x_s, s.offset) if sprung else met.f
    flow_j = h * dot(met.f, met.xd)
    u_j, v_j = s.u_j + max(flow_j, 0.0), s.v_j + max(-flow_j, 0.0)
    lost_j = met.lost_j + h * contact_heat(met.contact, met.rate)
    s = UserPort(avatar, met.kept, s.offset, x_s, answer, u_j, v_j, met.sent_j, s.extra)
    return s, lost_j


@environment_energies.member(AvatarEndParams)
def _energies(p: AvatarEndParams, s: Environment) -> Vector:
    accounts = controller_energies(s.ports[0].brake)
    for i in range(1, len(s.ports)):
        accounts = each(_sum, (accounts, controller_energies(s.ports[i].brake)))
    stored: Vector = (kinetic_j(s.body, p.body), potential_j(s))
    return stored + accounts


def _sum(one: float, other: float) -> float:
    return one + other


@port_shown.member(AvatarEndParams)
def port_without_waves(p: Any, s: Environment, user: int) -> PortShown:
    """Return a port whose waves are none."""
    port = s.ports[user]
    return PortShown(zero(port.v_s), in_touch(port), 0.0)


def pulled(
    kept: Any, contact: Contact, stretch: Vector, velocity: Vector, law: Any, body: Body, h: float
) -> Met:
    """Let the spring and damper of a law pull an avatar against its contact (backward Euler).

    ::

        f_s = K (stretch - h xd_s) + B (velocity - xd_s),   x_s += h xd_s

    is xd_s = free - f_s/Z with Z = K h + B: solved as at a wave port, with the object as sampled.
    """
    impedance = law.stiffness * h + law.damping
    free = each(_free, (stretch, velocity), law.stiffness, law.damping, impedance)
    f = contact_unwrapped(contact, free, body.xd, impedance, h)
    xd = each(loaded_axis, (free, f), impedance)
    contact, lost_j = slid(contact, scaled(xd, h))
    return Met(kept, xd, f, contact, minus(xd, body.xd), -1.0, lost_j)


def _free(stretch: float, velocity: float, k: float, b: float, impedance: float) -> float:
    return (k * stretch + b * velocity) / impedance
