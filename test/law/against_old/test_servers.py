# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The server's ports, contacts and couplings as pure functions do what the classes do."""

import random

import numpy as np
import pytest

from pmwvc_core.law.safety.avatar_brake import AvatarBrake
from pmwvc_core.law.safety.brake_force import resting_brake
from pmwvc_core.law.server.avatar import Avatar
from pmwvc_core.law.server.body import Body, body_law, changed_body, kinetic_j, wall_law
from pmwvc_core.law.server.contacts import Contact, ContactLaw, Spring, touching
from pmwvc_core.law.server.energies import potential_j
from pmwvc_core.law.server.implicit import Implicit
from pmwvc_core.law.server.sampled import OneFrameLate, OneStepDelay, Unwrapped, weights
from pmwvc_core.law.server.server_port import (
    Environment,
    EnvironmentParams,
    Sums,
    UserPort,
    changed_port,
    environment_step,
    joined,
    left,
)
from pmwvc_core.law.server_step import Came
from pmwvc_core.law.wave.wave import impedance
from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.server.factory import make_ports
from pmwvc_core.server.port import WaveServer

COUPLINGS = {
    "implicit": lambda old, new: Implicit(0),
    "unwrapped": Unwrapped,
    "one_step_delay": OneStepDelay,
    "one_frame_late": lambda old, new: OneFrameLate(0),
}


def value(vector):
    return vector[0] if len(vector) == 1 else np.array(vector)


def same(got, wanted, atol=1e-12):
    wanted = np.broadcast_to(np.ravel(wanted), np.shape(np.ravel(got)))
    assert np.allclose(np.ravel(got), wanted, rtol=1e-9, atol=atol), (got, wanted)


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


@pytest.mark.parametrize("coupling", COUPLINGS)
@pytest.mark.parametrize("axes", [1, 3])
@pytest.mark.parametrize("seed", range(4))
def test_every_step_of_both_is_the_same(coupling, axes, seed):
    luck = random.Random(seed)
    environment = "wall" if seed % 4 == 3 else "cube"
    integrator = luck.choice(["forward_euler", "backward_euler", "trapezoid"])
    params = ServerParams(
        coupling=coupling, environment=environment, integrator=integrator, period_s=0.008
    )
    contacts = [
        ContactParams(
            contact=luck.choice(["grip", "bilateral"]),
            contact_stiffness=luck.choice([200.0, 800.0]),
            contact_damping=luck.choice([0.0, 2.0]), gap_m=0.002,
        )
        for _ in range(2)
    ]  # fmt: skip
    bs = [luck.choice([12.5, 40.0]) for _ in range(2)]
    size = params.object_size_m
    old = WaveServer(params, make_ports(params, contacts, bs, dof=axes, sides=[-1, 1]))
    brakes = seed % 2 == 1
    if brakes:
        old.fit_brakes(params.period_s)
    zero = (0.0,) * axes
    cube = environment == "cube"
    law = body_law(params.object_mass, params.object_damping, 0.008) if cube else wall_law(0.008)
    chosen = COUPLINGS[coupling](*weights(integrator, 0.008))
    p = EnvironmentParams(chosen, law, brakes)
    ports = tuple(port(c, b, s, size, axes) for c, b, s in zip(contacts, bs, (-1, 1), strict=True))
    s = Environment(ports, Body(zero, zero), 0.0, 0)
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
    for step in range(1200):
        if step == 40:
            join(1)
        if step == 700:
            old.leave(0)
            one, lost = left(s.ports[0])
            s = Environment((one, s.ports[1]), s.body, s.dissipated_j + lost, 0)
        if step == 800:
            join(0)
        if step == 500 and cube:
            new = ServerParams(
                coupling=coupling, environment=environment, integrator=integrator, period_s=0.008,
                object_mass=1.0,
            )  # fmt: skip
            old.configure(new)
            changed = body_law(1.0, new.object_damping, 0.008)
            s = Environment(s.ports, changed_body(s.body, p.body, changed), s.dissipated_j, 0)
            p = EnvironmentParams(chosen, changed, brakes)
        if step in (300, 600):
            k, d = luck.choice([150.0, 900.0]), luck.choice([0.0, 3.0])
            new = ContactParams(
                contact=contacts[1].contact, contact_stiffness=k, contact_damping=d, gap_m=0.002
            )
            old.configure_user(1, new, bs[1])
            one, lost = changed_port(s.ports[1], k, d, impedance(bs[1]))
            s = Environment((s.ports[0], one), s.body, s.dissipated_j + lost, 0)
        toward = 0.25 * np.sin(0.05 * step)
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
            same(one.v_s, back[i])
            same(one.avatar.f, before.f_s)
            same(one.avatar.xd, before.xd_s)
            same(one.x_s, before.x_s)
            same(one.offset, before.offset)
            assert touching(one.avatar.contact) == bool(np.all(before.contact.touching))
            if brakes:
                same(one.brake.heat_j, before.brake.heat_j)
                if one.brake.heat_j:
                    seen.add("brakes")
            if touching(one.avatar.contact):
                seen.add("touches")
            else:
                seen.add("free")
        same(s.body.x, old.body.x)
        same(s.dissipated_j, old.dissipated)
        same(kinetic_j(s.body, p.body), old.kinetic)
        same(potential_j(s), old.potential)
    for one, before in zip(s.ports, old.ports, strict=True):
        same(one.sums.u_j, before.energy_u_s)
        same(one.sums.v_j, before.energy_v_s)
    print(seen)
