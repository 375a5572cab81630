# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Black boxes, their port and the compensations as pure functions do what the classes do."""

import math
import random

import numpy as np
import pytest

from pmwvc_core.law.black_box import compensations
from pmwvc_core.law.black_box.black_box import (
    Accounts,
    BlackBox,
    BlackBoxParams,
)
from pmwvc_core.law.black_box.hunt_crossley import Dent, SoftBody, SoftBodyParams
from pmwvc_core.law.black_box.seen import resting_seen
from pmwvc_core.law.black_box.touched import Drive, FreeCube, Visitor, Wall
from pmwvc_core.law.safety.avatar_brake import AvatarBrake
from pmwvc_core.law.safety.brake_force import resting_brake
from pmwvc_core.law.server.avatar import Avatar
from pmwvc_core.law.server.body import Body, body_law, wall_law
from pmwvc_core.law.server.contacts import Contact, ContactLaw, Spring
from pmwvc_core.law.server.sampled import weights
from pmwvc_core.law.server.server_port import (
    Environment,
    Sums,
    UserPort,
    environment_step,
    joined,
    left,
)
from pmwvc_core.law.server_step import Came
from pmwvc_core.law.wave.wave import impedance
from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.server.black_box.containment import Asked, directly
from pmwvc_core.server.black_box.faults import Faults
from pmwvc_core.server.black_box.interface import EnvironmentSetup
from pmwvc_core.server.black_box.outside import Outside
from pmwvc_core.server.black_box.port import BlackBoxServer
from pmwvc_core.server.black_box.touch import TouchedWall
from pmwvc_core.server.environments import make_black_box
from pmwvc_core.server.factory import make_ports

H = 0.008
LATE = {"decoding": "late"}
TREATED = {
    "none": compensations.Untreated(0),
    "printed": compensations.AsPublished((0.0, 0.0)),
    "corrected": compensations.Corrected(0.0),
    "ledger": compensations.JointLedger(0.0, 0.0, 0.0),
}


def value(vector):
    return vector[0] if len(vector) == 1 else np.array(vector)


def same(got, wanted, atol=1e-12):
    wanted = np.broadcast_to(np.ravel(wanted), np.shape(np.ravel(got)))
    assert np.allclose(np.ravel(got), wanted, rtol=1e-10, atol=atol), (got, wanted)


def port(contact, b, side, size, axes):
    zero = (0.0,) * axes
    grips = contact.grips
    law = ContactLaw(
        contact.contact_stiffness, contact.contact_damping, -float(side), 0.5 * side * size,
        contact.gap_m,
    )  # fmt: skip
    springs = tuple(
        Spring(0.0, 0.5 * side * size if grips and not k else 0.0, grips and not k, False)
        for k in range(axes)
    )
    avatar = Avatar(False, impedance(b), zero, zero, zero, Contact(law, grips, springs), zero)
    return UserPort(
        avatar, AvatarBrake(resting_brake(zero), 0.0), zero, zero, zero, Sums(0.0, 0.0, -1.0), ()
    )


class Faulty(TouchedWall):
    """A wall of a laboratory that raises, returns what is no force, and jumps."""

    steps = 0

    def step(self, position, velocity, dt):
        self.steps += 1
        force = super().step(position, velocity, dt)
        if self.steps % 50 == 0:
            raise RuntimeError("no answer")
        if self.steps % 70 == 0:
            force[0] = np.nan
        if self.steps % 90 == 0:
            force[1] += 5e4
        return force


def environment(params, contacts, ports, axes):
    zero, name = (0.0,) * axes, params.environment
    if name == "hunt_crossley":
        soft = params.hunt_crossley
        dents = tuple(
            Dent(False, 0.0, 0.0, c.contact_stiffness, (-float(side), *zero[1:]))
            for c, side in zip(contacts, (-1, 1), strict=True)
        )
        face = 0.5 * params.object_size_m
        return SoftBody(dents), SoftBodyParams(soft.exponent, soft.damping, face)
    visitors = tuple(Visitor(False, zero, each.avatar.contact) for each in ports)
    if name == "cube":
        law = body_law(params.object_mass, params.object_damping, params.period_s)
        return FreeCube(visitors, Body(zero, zero)), law
    drive = params.active_wall
    amplitude = drive.amplitude_m if name == "active_wall" else 0.0
    wall = Wall(visitors, Body(zero, zero), 0.0)
    return wall, Drive((amplitude, *zero[1:]), 2.0 * math.pi * drive.frequency_hz)


def both(name, compensation, integrator, line, axes, luck, brakes, outside):
    params = ServerParams(
        coupling="unknown", environment=name, compensation=compensation, integrator=integrator,
        period_s=H, **line,
    )  # fmt: skip
    contacts = [
        ContactParams(
            contact=luck.choice(["grip", "bilateral"]),
            contact_stiffness=luck.choice([200.0, 2000.0]),
            contact_damping=luck.choice([0.0, 2.0]), gap_m=0.002,
        )
        for _ in range(2)
    ]  # fmt: skip
    bs = [luck.choice([12.5, 40.0]) for _ in range(2)]
    made = make_ports(params, contacts, bs, dof=axes, sides=[-1, 1])
    setup = EnvironmentSetup(axes, H, (-1, 1), params, tuple(contacts))
    asked = Faulty(setup) if outside else make_black_box(setup)
    old = BlackBoxServer(params, made, asked)
    if brakes:
        old.fit_brakes(H)
    zero, size = (0.0,) * axes, params.object_size_m
    ports = tuple(port(c, b, s, size, axes) for c, b, s in zip(contacts, bs, (-1, 1), strict=True))
    if outside:
        asking = Asked(Faulty(setup))
        state = Outside(asking, directly, Faults("server.environment", "lab"), (False, False))
        law = 0
    else:
        state, law = environment(params, contacts, ports, axes)
    old_s, new_s = weights(integrator, H)
    sloped = name in ("wall_with_slope", "hunt_crossley")
    identity = tuple(tuple(row) for row in np.eye(axes).tolist())
    p = BlackBoxParams(
        law, compensations.compensation_params(params), wall_law(H), brakes, old_s, new_s, sloped,
        params.learns and not sloped, identity,
    )  # fmt: skip
    users = tuple(resting_seen(zero, b / H) for b in bs)
    accounts = Accounts(0.0, 0.0, 0.0, 0.0)
    box = BlackBox(zero, zero, state, TREATED[compensation], users, 0.0, -1.0, accounts)
    return old, Environment(ports, box, 0.0, 0), p, size


@pytest.mark.parametrize(
    "name", ["wall", "wall_with_slope", "active_wall", "cube", "hunt_crossley", "outside"]
)
@pytest.mark.parametrize("axes", [1, 3])
@pytest.mark.parametrize("seed", range(3))
def test_every_step_of_both_is_the_same(name, axes, seed):
    luck = random.Random(seed)
    compensation = list(TREATED)[seed % 4]
    integrator = luck.choice(["forward_euler", "backward_euler", "backward_euler", "trapezoid"])
    line = {} if seed < 6 else LATE
    brakes = seed % 2 == 1
    outside = name == "outside"
    old, s, p, size = both(
        "wall" if outside else name, compensation, integrator, line, axes, luck, brakes, outside
    )
    zero = (0.0,) * axes
    seen = set()

    def join(i):
        nonlocal s
        inside = luck.choice([0.0, 0.01])
        at = ((2 * i - 1) * (size / 2 + 0.01 - 2 * inside), *zero[1:])
        old.join(i, value(at))
        one, lost = joined(s.ports[i], at, s.body)
        s = Environment((one, s.ports[1]) if i == 0 else (s.ports[0], one), s.body,
                        s.dissipated_j + lost, 0)  # fmt: skip

    join(0)
    waits = [False, False]
    for step in range(600):
        if step in (40, 450):
            join(1)
        if step == 300:
            old.leave(0)
            one, lost = left(s.ports[0])
            s = Environment((one, s.ports[1]), s.body, s.dissipated_j + lost, 0)
        if step == 400:
            join(0)
        toward = 0.5 * np.sin(0.05 * step)
        waves = tuple(
            (
                (1 - 2 * i) * toward + luck.gauss(0.0, 0.05),
                *(luck.gauss(0.0, 0.05) for _ in zero[1:]),
            )
            for i in range(2)
        )
        if luck.random() < 0.05:
            waits = [luck.random() < 0.3, luck.random() < 0.3]
        if any(waits):
            waves = tuple(zero if w else u for w, u in zip(waits, waves, strict=True))
        for i in range(2):
            old.interrupt(i, waits[i])
        back = old.step([value(u) for u in waves])
        came = tuple(Came(u, zero, w, 0.0) for u, w in zip(waves, waits, strict=True))
        s = environment_step(p, s, came)
        for i in range(2):
            one, before = s.ports[i], old.ports[i]
            if not one.avatar.present:
                continue
            where = f"step {step} user {i}"
            assert np.allclose(np.ravel(one.v_s), np.ravel(back[i]), rtol=1e-10, atol=1e-12), where
            same(one.avatar.f, before.f_s)
            same(one.avatar.xd, before.xd_s)
            same(one.x_s, before.x_s)
            if any(one.avatar.f):
                seen.add("touches")
        same(s.body.x, old.body.x)
        same(s.dissipated_j, old.dissipated)
        if outside:
            continue
        assert all(user.usable and not user.jumped for user in s.body.users) or old.faults.steps
    assert not outside or old.faults.steps > 20
    accounts = old.accounts
    same(s.body.accounts.contained_j, accounts["contained"], 1e-11)
    same(s.body.accounts.environment_j, accounts["environment"])
    same(s.body.accounts.late_j, accounts["late_decoding"])
    same(s.body.accounts.withheld_j, accounts["withheld"])
    for one, before in zip(s.ports, old.ports, strict=True):
        same(one.sums.u_j, before.energy_u_s)
        same(one.sums.v_j, before.energy_v_s)
    assert "touches" in seen
