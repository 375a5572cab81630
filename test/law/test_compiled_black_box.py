# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Black boxes and their compensations give the same numbers compiled."""

import math

import numpy as np
import pytest

from pmwvc_core.compiled import compiled
from pmwvc_core.law.black_box import compensations
from pmwvc_core.law.black_box.black_box import Accounts, BlackBoxParams, BoxState
from pmwvc_core.law.black_box.hunt_crossley import Dent, SoftBody, SoftBodyParams
from pmwvc_core.law.black_box.secant import Seen, resting_secant
from pmwvc_core.law.black_box.touched import FreeCube, Swing, Visitor, Wall
from pmwvc_core.law.family import NOTHING
from pmwvc_core.law.motion import Body, body_law
from pmwvc_core.law.safety.brakes import AvatarBrake, resting_brake
from pmwvc_core.law.server.contacts import Avatar, Contact
from pmwvc_core.law.server.server_port import Came, SharedScene, UserPort, environment_step, joined
from pmwvc_core.law.server.springs import ContactLaw, Spring
from pmwvc_core.law.vectors import scaled, zero
from pmwvc_core.law.wave.wave import impedance
from pmwvc_core.params import ServerParams

H = 0.008
TREATED = (
    NOTHING,
    compensations.AsPublished((0.0, 0.0)),
    compensations.Corrected(0.0),
    compensations.JointLedger(0.0, 0.0, 0.0),
)


def driven(s, p, along):
    rest = zero(along)
    for step in range(400):
        u = 0.5 * math.sin(0.05 * step) + 0.05 * math.sin(1.7 * step)
        waits = 200 < step < 220
        left = Came(scaled(along, 0.0 if waits else u), rest, waits, 0.0, ())
        right = Came(scaled(along, -u), rest, False, 0.0, ())
        s = environment_step(p, s, (left, right))
    return s


driven.__module__ = "pmwvc_core.law.driver"


def leaves(value):
    if isinstance(value, tuple):
        return [leaf for each in value for leaf in leaves(each)]
    return [float(value)]


def port(side, axes):
    rest = (0.0,) * axes
    law = ContactLaw(900.0, 1.0, -float(side), 0.05 * side, 0.002)
    springs = tuple(Spring(0.0, 0.0 if k else 0.05 * side, not k) for k in range(axes))
    contact = Contact(law, springs)
    avatar = Avatar(False, impedance(12.5), rest, rest, rest, contact, rest)
    brake = AvatarBrake(resting_brake(rest), 0.0)
    return UserPort(avatar, brake, rest, rest, rest, 0.0, 0.0, -1.0, ())


def boxes(ports, axes):
    rest = (0.0,) * axes
    visitors = tuple(Visitor(False, rest, each.avatar.contact) for each in ports)
    dents = tuple(Dent(False, 0.0, 0.0, 900.0, (s, *rest[1:])) for s in (1.0, -1.0))
    wall = Wall(visitors, Body(rest, rest), 0.0)
    return (
        (wall, Swing((0.005, *rest[1:]), 9.0), False),
        (wall, Swing(rest, 0.0), True),
        (FreeCube(visitors, Body(rest, rest)), body_law(0.5, 1.0, H), False),
        (SoftBody(dents, Body(rest, rest)), SoftBodyParams(1.5, 20.0, 0.05), True),
    )


@pytest.mark.parametrize("axes", [1])
def test_every_black_box(axes):
    rest = (0.0,) * axes
    ports = tuple(port(side, axes) for side in (-1, 1))
    identity = tuple(tuple(row) for row in np.eye(axes).tolist())
    params = compensations.compensation_params(ServerParams(period_s=H))
    for (asked, law, sloped), treated in zip(boxes(ports, axes), TREATED, strict=True):
        p = BlackBoxParams(
            law, params, body_law(float("inf"), 0.0, H), True, 0.0, H, sloped, not sloped, identity
        )
        users = tuple(Seen(resting_secant(rest, 12.5 / H, False), rest, rest, rest) for _ in ports)
        sums = Accounts(0.0, 0.0, 0.0, 0.0)
        box = BoxState(rest, rest, asked, treated, users, 0.0, -1.0, sums)
        there = [
            joined(each, (0.055 * side, *rest[1:]), box)[0]
            for each, side in zip(ports, (-1, 1), strict=True)
        ]
        given = (SharedScene(tuple(there), box, 0.0, 0), p, (1.0, 0.2, -0.1)[:axes])
        wanted = driven(*given)
        got = leaves(compiled(driven)(*given))
        assert np.allclose(got, leaves(wanted), rtol=1e-9, atol=1e-12)
        assert wanted.body.accounts.environment_j != 0.0
