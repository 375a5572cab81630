# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Direct coupling: position and velocity go up each frame, the contact force comes back, held.

What networked haptics did before wave variables, and what App. B compares with (Fig. 3). It is not
passive: the force is as old as the way there and back. An avatar stands where its device stood
when it last reported; ``xd_s`` is the velocity as reported::

    f_s(n) = K [x_m + offset - x_o(n)] + B [xd_m - xd_o(n)],    F_m = f_s as last received
"""

from typing import NamedTuple

from pmwvc_core.law.family import Nothing
from pmwvc_core.law.server.body import Body
from pmwvc_core.law.server.contacts import Contact, contact_force, offset_of, slid
from pmwvc_core.law.vectors import Vector, minus, plus, zero
from pmwvc_core.law.without_waves import device_end
from pmwvc_core.law.without_waves.avatar_end import Met, Reported, meet
from pmwvc_core.law.without_waves.device_end import DeviceEndParams, DeviceMotion


class Held(NamedTuple):
    """The force as last received [N]."""

    force: Vector


class Direct(NamedTuple):
    """The law at either end; it has no parameters."""

    none: int


@device_end.device_answer.member(Held)
def _answer(s: Held, wave: Vector, silent: bool, motion: DeviceMotion, p: DeviceEndParams) -> Held:
    return Held(zero(wave) if silent else wave)


@device_end.device_force.member(Held)
def _force(s: Held, motion: DeviceMotion, p: DeviceEndParams) -> tuple[Held, Vector]:
    return s, s.force


@meet.member(Direct)
def _meet(
    p: Direct, kept: Nothing, report: Reported, x_s: Vector, xd_s: Vector, contact: Contact,
    body: Body, h: float,
) -> Met:  # fmt: skip
    """Put the avatar where the device is and form the force."""
    place = plus(body.x, offset_of(contact))
    contact, lost_j = slid(contact, minus(report.position, place))
    rate = minus(report.velocity, body.xd)
    f = contact_force(contact, rate)
    return Met(kept, report.velocity, f, contact, rate, -1.0, lost_j)
