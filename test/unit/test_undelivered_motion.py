# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A port that learns brings its avatar to where the waves brought the device, whatever is touched,
and takes no force from an environment that jumps.
"""

import numpy as np
import pytest
from support.law_rigs import Users

from pmwvc_core.params import ContactParams, ServerParams

B_W, PERIOD_S, TICK_S = 25.0, 0.02, 0.001


class Does:
    """An environment that calls a function of its number of steps, positions and velocities."""

    def __init__(self, force):
        self.force, self.steps = force, 0

    def step(self, position, velocity, dt):
        self.steps += 1
        return self.force(self.steps, position, velocity) + 0.0 * position


class Body:
    """A mass that whoever touches it moves, as a physics engine with stiff contacts has it: faces
    (one sided by ``sides``) at rest where the avatars begin.
    """

    def __init__(self, stiffness, *, mass, damping, sides=None):
        self.stiffness, self.mass, self.damping, self.sides = stiffness, mass, damping, sides
        self.at = self.speed = 0.0
        self.before = None

    def step(self, position, velocity, dt):
        here = position[:, 0]
        if self.before is None:
            self.before = here - dt * velocity[:, 0]
            self.rest = self.before if self.sides is None else 0.01 * self.sides
        for part in np.arange(1, 11) / 10.0:
            deep = self.before + (here - self.before) * part - self.rest - self.at
            if self.sides is not None:
                deep = -self.sides * np.maximum(-self.sides * deep, 0.0)
            force = self.stiffness * deep
            self.speed += 0.1 * dt * (force.sum() - self.damping * self.speed) / self.mass
            self.at += 0.1 * dt * self.speed
        self.before = here.copy()
        return force[:, np.newaxis] * np.ones_like(position)


def server_around(environment, *places, **values):
    places = places or (0.0,)
    params = ServerParams(coupling="unknown", period_s=PERIOD_S, **values)
    contacts = [ContactParams(contact="bilateral")] * len(places)
    server = Users(params, contacts, b=B_W, environment=environment)
    for user, place in enumerate(places):
        server.join(user, place)
    return server


def pressed(environment, push, *, seconds=8.0):
    """A hand pushes a device of 0.3 kg; return how far the device stands from its avatar [m]."""
    server = server_around(environment)
    x = xd = v = sent = 0.0
    for tick in range(round(seconds / TICK_S)):
        force = B_W * xd - np.sqrt(2.0 * B_W) * v
        xd += TICK_S * (push(tick * TICK_S) - force - 5.0 * xd) / 0.3
        x += TICK_S * xd
        sent += (np.sqrt(2.0 * B_W) * xd - v) * TICK_S / PERIOD_S
        if (tick + 1) % round(PERIOD_S / TICK_S) == 0:
            v, sent = server.step([sent])[0], 0.0
            assert server.taken_j >= -1e-9
    return x - server.x_s[0], server


def slow_press(time_s):
    """1 N for three seconds."""
    return min(time_s, 1.0) if time_s < 4.0 else 0.0


BODIES = [
    (3000.0, {"mass": 2.0, "damping": 5.0}),
    (6000.0, {"mass": 2.0, "damping": 5.0}),
    (1500.0, {"mass": 0.5, "damping": 20.0}),
]


@pytest.mark.parametrize(("stiffness", "body"), BODIES)
def test_a_body_that_gives_way_leaves_no_distance(stiffness, body, monkeypatch):
    """K T of 1.2 b to 4.8 b; at rest again the device is where its avatar is. Without repayment it
    would be lost (the control).
    """
    apart_m, server = pressed(Body(stiffness, **body), slow_press)
    assert abs(apart_m) < 0.1e-3
    assert server.faults.steps == 0
    monkeypatch.setattr("pmwvc_core.law.black_box.secant.REPAID", 0.0)
    assert abs(pressed(Body(stiffness, **body), slow_press)[0]) > 2e-3


def test_a_damper_leaves_the_device_at_its_avatar():
    """B = 30 N s/m keeps the slope above K T; what that misses is made up."""
    soft = Does(lambda _, x, xd: np.maximum(50.0 * x + 30.0 * xd, 0.0) * (x > 0.0))
    apart_m, _ = pressed(soft, lambda time_s: min(time_s, 1.0))
    assert apart_m == pytest.approx(PERIOD_S / (2.0 * B_W), abs=0.1e-3)  # the hold's


@pytest.mark.parametrize("wave", [0.05, -0.2])
def test_an_environment_that_jumps_is_contained_counted_and_named(wave):
    """A wall that is put behind the avatar, once: 56 N in one step upon an avatar in contact, or
    outside, that hardly moves.
    """
    reset = Does(lambda step, x, _: 3000.0 * np.maximum(x + 0.018 * (step == 200), 0.0))
    server = server_around(reset)
    for step in range(220):
        server.step([wave if wave > 0.0 or step < 2 else 0.0])
        assert abs(server.f_s[0]) < 5.0
    assert server.faults.steps == 1
    assert "jumped while hardly anything moved for users [0]" in server.faults.text


def test_a_force_that_stays_is_taken_soon():
    server = server_around(Does(lambda step, *_: 40.0 * (step > 20)))
    found = [(server.step([0.0]), server.f_s[0])[1] for _ in range(40)]
    assert found[19:24] == [0.0, 0.0, 0.0, 0.0, 40.0]  # 10 N more per step
    assert found[-1] == 40.0


@pytest.mark.parametrize("stiffness", [3000.0, 100000.0])
@pytest.mark.parametrize("speed", [0.02, 0.5])
def test_an_impact_of_an_avatar_is_no_fault(stiffness, speed):
    server = server_around(Does(lambda _, x, xd: stiffness * np.maximum(x - 0.05, 0.0)))
    peak = 0.0
    for _ in range(round(0.1 / (speed * PERIOD_S))):
        server.step([speed * np.sqrt(B_W / 2.0)])
        peak = max(peak, server.f_s[0])
    assert peak > speed * B_W
    assert server.faults.steps == 0


def test_a_body_that_another_user_pushes_is_no_fault():
    """User 2 drives a body of 2 kg against the avatar of user 1, who rests."""
    body = Body(4000.0, mass=2.0, damping=5.0, sides=np.array([-1.0, 1.0]))
    server = server_around(body, -0.05, 0.03, compensation="ledger")
    touched = 0.0
    for _ in range(100):
        server.step([0.0, -0.3 * np.sqrt(B_W / 2.0)])
        touched = max(touched, server.f_s[0])
    assert touched > 1.0
    assert server.faults.steps == 0
