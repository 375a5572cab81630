# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Environments known by their forces only, made from parameters."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from pmwvc_core.law.black_box.black_box import Accounts, BlackBox, BlackBoxParams
from pmwvc_core.law.black_box.compensations import compensation_params
from pmwvc_core.law.black_box.hunt_crossley import Dent, SoftBody, SoftBodyParams
from pmwvc_core.law.black_box.seen import resting_seen
from pmwvc_core.law.black_box.touched import Drive, FreeCube, Visitor, Wall
from pmwvc_core.law.server.body import Body, body_law, wall_law
from pmwvc_core.law.server.contacts import Contact
from pmwvc_core.law.server.sampled import weights
from pmwvc_core.params import ServerParams
from pmwvc_core.scenario import scenario as scenarios
from pmwvc_core.server.black_box.containment import Asked, Call, Outside
from pmwvc_core.server.black_box.faults import Faults
from pmwvc_core.server.black_box.interface import EnvironmentSetup
from pmwvc_core.server.compensations import COMPENSATIONS
from pmwvc_core.server.environments import PLUGINS, environment_of
from pmwvc_core.wave import impedance as impedances

Contacts = Sequence[Contact]


def _visitors(contacts: Contacts, axes: int) -> tuple[Visitor, ...]:
    return tuple(Visitor(False, (0.0,) * axes, contact) for contact in contacts)


def _resting(axes: int) -> Body:
    return Body((0.0,) * axes, (0.0,) * axes)


def _wall(server: ServerParams, contacts: Contacts, axes: int) -> tuple[Wall, Drive]:
    return Wall(_visitors(contacts, axes), _resting(axes), 0.0), Drive((0.0,) * axes, 0.0)


def _driven(server: ServerParams, contacts: Contacts, axes: int) -> tuple[Wall, Drive]:
    drive = server.active_wall
    amplitude = (drive.amplitude_m, *(0.0,) * (axes - 1))
    wall, _ = _wall(server, contacts, axes)
    return wall, Drive(amplitude, 2.0 * math.pi * drive.frequency_hz)


def _cube(server: ServerParams, contacts: Contacts, axes: int) -> tuple[FreeCube, Any]:
    law = body_law(server.object_mass, server.object_damping, server.period_s)
    return FreeCube(_visitors(contacts, axes), _resting(axes)), law


def _soft(server: ServerParams, contacts: Contacts, axes: int) -> tuple[SoftBody, Any]:
    soft, rest = server.hunt_crossley, (0.0,) * (axes - 1)
    dents = tuple(
        Dent(False, 0.0, 0.0, contact.law.stiffness, (contact.law.inward, *rest))
        for contact in contacts
    )
    face = 0.5 * server.object_size_m
    return SoftBody(dents, _resting(axes)), SoftBodyParams(soft.exponent, soft.damping, face)


ENVIRONMENTS: Mapping[str, Callable[[ServerParams, Contacts, int], tuple[Any, Any]]] = {
    "wall": _wall,
    "wall_with_slope": _wall,
    "active_wall": _driven,
    "cube": _cube,
    "hunt_crossley": _soft,
}


def black_box_params(
    server: ServerParams, contacts: Contacts, axes: int, *, brakes: bool
) -> BlackBoxParams:
    """Return the parameters of a black box and its ports."""
    law, sloped = None, environment_of(server.environment).sloped
    if server.environment in ENVIRONMENTS:
        _, law = ENVIRONMENTS[server.environment](server, contacts, axes)
    return BlackBoxParams(
        law,
        compensation_params(server),
        wall_law(server.period_s),
        brakes,
        *weights(server.integrator, server.period_s),
        sloped,
        server.learns and not sloped,
        tuple(tuple(row) for row in np.eye(axes).tolist()),
    )


def resting_box(
    server: ServerParams,
    users: Sequence["scenarios.User"],
    contacts: Contacts,
    own: Any,
    call: Call,
) -> BlackBox:
    """Return a black box that nobody touches; ``call`` is how one of another package is asked."""
    axes = len(contacts[0].springs)
    rest = (0.0,) * axes
    if server.environment in ENVIRONMENTS:
        state, _ = ENVIRONMENTS[server.environment](server, contacts, axes)
    else:
        sides, of_users = tuple(user.side for user in users), tuple(user.contact for user in users)
        values = getattr(own, server.environment, None)
        setup = EnvironmentSetup(axes, server.period_s, sides, server, of_users, values)
        faults = Faults("server.environment", server.environment)
        state = Outside(
            Asked(PLUGINS.make(server.environment, setup)), call, faults, (False,) * len(users)
        )
    least = (float(impedances.smallest(user.server_impedance)) for user in users)
    return BlackBox(
        rest,
        rest,
        state,
        COMPENSATIONS.of(server.compensation).rest(len(users)),
        tuple(resting_seen(rest, b / server.period_s) for b in least),
        0.0,
        -1.0,
        Accounts(0.0, 0.0, 0.0, 0.0),
    )
