# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Direct coupling: position and velocity go up each frame, the contact force comes back, held.

What networked haptics did before wave variables, and what App. B compares with (Fig. 3). It is not
passive: the force is as old as the way there and back. An avatar stands where its device stood
when it last reported; ``xd_s`` is the velocity as reported::

    f_s(n) = K [x_m + offset - x_o(n)] + B [xd_m - xd_o(n)],    F_m = f_s as last received
"""

from typing import NamedTuple

from pmwvc_core.law.server.avatar import Avatar
from pmwvc_core.law.server.body import Body
from pmwvc_core.law.server.contacts import contact_force, offset_of, slid
from pmwvc_core.law.server.server_port import UserPort
from pmwvc_core.law.vectors import Vector, minus, plus, zero
from pmwvc_core.law.without_waves import device_end
from pmwvc_core.law.without_waves.avatar_end import Met, Reported, meet
from pmwvc_core.law.without_waves.device_end import DeviceEndParams


class Held(NamedTuple):
    """The force as last received [N]."""

    force: Vector


class Direct(NamedTuple):
    """The law at either end; it has no parameters."""

    none: int


@device_end.device_answer.member(Held)
def _answer(s: Held, wave: Vector, silent: bool, x: Vector, p: DeviceEndParams) -> Held:
    return Held(zero(wave) if silent else wave)


@device_end.device_force.member(Held)
def _force(s: Held, x: Vector, xd: Vector, p: DeviceEndParams) -> tuple[Held, Vector]:
    return s, s.force


@meet.member(Direct)
def _meet(p: Direct, s: UserPort, a: Avatar, report: Reported, body: Body, h: float) -> Met:
    """Put the avatar where the device is and form the force."""
    place = plus(body.x, offset_of(a.contact))
    contact, lost_j = slid(a.contact, minus(report.position, place))
    rate = minus(report.velocity, body.xd)
    f = contact_force(contact, rate)
    return Met(s.brake, report.velocity, f, contact, rate, -1.0, lost_j)
