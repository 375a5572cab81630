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


class Body:
    """A mass that whoever touches it moves, as a physics engine with stiff contacts has it."""

    def __init__(self, stiffness, *, mass, damping=0.0, spring=0.0):
        self.stiffness, self.mass, self.damping, self.spring = stiffness, mass, damping, spring
        self.at = self.before = None
        self.speed = 0.0

    def step(self, position, velocity, dt):
        here = position[:, 0]
        if self.at is None:
            self.before, self.at = here - dt * velocity[:, 0], 0.0
            self.rest = self.before.copy()
        for part in np.arange(1, 11) / 10.0:
            deep = self.before + (here - self.before) * part - self.rest - self.at
            force = self.stiffness * deep
            back = self.damping * self.speed + self.spring * self.at
            self.speed += 0.1 * dt * (force.sum() - back) / self.mass
            self.at += 0.1 * dt * self.speed
        self.before = here.copy()
        return force[:, np.newaxis] * np.ones_like(position)


def server_around(environment, *, users=1, **values):
    params = ServerParams(coupling="unknown", period_s=PERIOD_S, **values)
    contacts = [ContactParams(contact="bilateral")] * users
    server = Users(params, contacts, b=B_W, environment=environment)
    for user in range(users):
        server.join(user, 0.0)
    return server


def pressed(environment, push, *, seconds=8.0):
    """A hand pushes a device of 0.3 kg; return how far the device stands from its avatar [m]."""
    server = server_around(environment)
    x = xd = v = sent = 0.0
    apart = []
    for tick in range(round(seconds / TICK_S)):
        force = B_W * xd - np.sqrt(2.0 * B_W) * v
        xd += TICK_S * (push(tick * TICK_S) - force - 5.0 * xd) / 0.3
        x += TICK_S * xd
        sent += (np.sqrt(2.0 * B_W) * xd - v) * TICK_S / PERIOD_S
        if (tick + 1) % round(PERIOD_S / TICK_S) == 0:
            v, sent = server.step([sent])[0], 0.0
            apart.append(x - server.x_s[0])
            assert server.taken_j >= -1e-9
    return np.array(apart), server


def slow_press(time_s):
    """1 N for three seconds."""
    return min(time_s, 1.0) if time_s < 4.0 else 0.0


BODIES = [
    (3000.0, {"mass": 2.0, "damping": 5.0}),
    (3000.0, {"mass": 0.5, "damping": 20.0}),
    (6000.0, {"mass": 2.0, "damping": 5.0}),
    (1500.0, {"mass": 0.5, "damping": 20.0}),
]


@pytest.mark.parametrize(("stiffness", "body"), BODIES)
def test_a_body_that_gives_way_leaves_no_distance(stiffness, body):
    """K T of 1.2 b to 4.8 b; at rest again the device is where its avatar is."""
    apart, server = pressed(Body(stiffness, **body), slow_press)
    assert abs(apart[-1]) < 0.1e-3
    assert server.faults.steps == 0


def test_without_repayment_it_would_be_lost(monkeypatch):
    monkeypatch.setattr("pmwvc_core.law.black_box.secant.REPAID", 0.0)
    left = [abs(pressed(Body(k, **body), slow_press)[0][-1]) for k, body in BODIES]
    assert min(left) > 2e-3
    assert max(left) > 0.1


def test_a_damper_leaves_the_device_at_its_avatar():
    """B = 30 N s/m keeps the slope above K T; what that misses is made up."""

    class Soft:
        def step(self, position, velocity, dt):
            return np.maximum(50.0 * position + 30.0 * velocity, 0.0) * (position > 0.0)

    apart, _ = pressed(Soft(), lambda time_s: min(time_s, 1.0))
    assert apart[-1] == pytest.approx(PERIOD_S / (2.0 * B_W), abs=0.1e-3)  # the hold's


class Reset:
    """A wall that the engine puts elsewhere, once: behind the avatar."""

    def __init__(self, *, stiffness=3000.0, at_step=200, by_m=0.018):
        self.stiffness, self.at_step, self.by_m, self.steps = stiffness, at_step, by_m, 0

    def step(self, position, velocity, dt):
        self.steps += 1
        face = 0.0 if self.steps != self.at_step else -self.by_m
        return self.stiffness * np.maximum(position - face, 0.0)


@pytest.mark.parametrize("wave", [0.05, -0.2])
def test_an_environment_that_jumps_is_contained(wave):
    """56 N in one step upon an avatar in contact, or outside, that hardly moves."""
    server = server_around(Reset())
    for step in range(220):
        server.step([wave if wave > 0.0 or step < 2 else 0.0])
        assert abs(server.f_s[0]) < 5.0


def test_a_force_that_stays_is_taken_soon():
    class Pushes(Reset):
        def step(self, position, velocity, dt):
            self.steps += 1
            return 40.0 + 0.0 * position if self.steps > self.at_step else 0.0 * position

    server = server_around(Pushes(at_step=20))
    found = [(server.step([0.0]), server.f_s[0])[1] for _ in range(40)]
    assert found[19:24] == [0.0, 0.0, 0.0, 0.0, 40.0]  # 10 N more per step
    assert found[-1] == 40.0


def test_a_jump_is_counted_and_named():
    server = server_around(Reset())
    for _ in range(220):
        server.step([0.05])
    assert server.faults.steps == 1
    assert "jumped while hardly anything moved for users [0]" in server.faults.text


@pytest.mark.parametrize("stiffness", [3000.0, 50000.0, 100000.0])
@pytest.mark.parametrize("speed", [0.02, 0.1, 0.5])
def test_an_impact_of_an_avatar_is_no_fault(stiffness, speed):
    class Wall:
        def step(self, position, velocity, dt):
            return stiffness * np.maximum(position - 0.05, 0.0)

    server = server_around(Wall())
    peak = 0.0
    for _ in range(round(0.1 / (speed * PERIOD_S))):
        server.step([speed * np.sqrt(B_W / 2.0)])
        peak = max(peak, server.f_s[0])
    assert peak > speed * B_W
    assert server.faults.steps == 0


def test_a_body_that_another_user_pushes_is_no_fault():
    """User 2 drives a body of 0.2 kg against the avatar of user 1, who rests."""

    class Between:
        at, speed = 0.0, 0.0

        def step(self, position, velocity, dt):
            left = np.maximum(position[0, 0] - (self.at - 0.01), 0.0)
            right = np.maximum(self.at + 0.01 - position[1, 0], 0.0)
            force = 4000.0 * np.array([[left], [-right]])
            self.speed += dt * (force.sum() - 5.0 * self.speed) / 2.0
            self.at += dt * self.speed
            return force

    params = {"compensation": "ledger"}
    server = server_around(Between(), users=2, **params)
    for user, place in enumerate((-0.05, 0.03)):
        server.leave(user)
        server.join(user, place)
    touched = 0.0
    for _ in range(100):
        server.step([0.0, -0.3 * np.sqrt(B_W / 2.0)])
        touched = max(touched, server.f_s[0])
    assert touched > 1.0
    assert server.faults.steps == 0
