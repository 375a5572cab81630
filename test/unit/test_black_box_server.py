# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The port of an unknown environment: its equations, its calls, and the containment of faults."""

import numpy as np
import pytest
from support.law_rigs import Users

from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.params.server import INTEGRATORS
from pmwvc_core.plugins import Unanswered

B_W = 25.0


def make(
    coupling="unknown",
    *,
    users=1,
    dof=1,
    contact="bilateral",
    k=500.0,
    damping=3.0,
    around=None,
    call=None,
    **values,
):
    touch = {"contact_stiffness": k, "contact_damping": damping, "gap_m": 0.002}
    params = ServerParams(coupling=coupling, **{"decoding": "late", **values})
    options = {} if call is None else {"call": call}
    contacts = [ContactParams(contact=contact, **touch)] * users
    return Users(params, contacts, b=B_W, axes=dof, environment=around, **options)


def white(users, dof, *, steps=200):
    rng = np.random.default_rng(3)
    for _ in range(steps):
        rows = rng.normal(0.0, 0.5, (users, dof))
        yield [float(row[0]) if dof == 1 else row for row in rows]


def seat_all(server):
    for user in range(len(server.s.ports)):
        place = -0.032 if user % 2 == 0 else 0.032  # the gap before the face
        server.join(user, place if server.axes == 1 else np.full(server.axes, place))


@pytest.mark.parametrize("dof", [1, 3])
@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize(
    ("known", "environment", "contact"),
    [
        ("one_step_delay", "wall", "bilateral"),
        ("one_step_delay", "wall", "grip"),
        ("unwrapped", "wall_with_slope", "bilateral"),
    ],
)
def test_a_wall_as_a_black_box_is_the_coupling_that_knows_it(
    known, environment, contact, integrator, dof
):
    """Decoded late; with its slope the loop is solved (App. C Eq. 4)."""
    names = {"dof": dof, "contact": contact, "integrator": integrator}
    one = make(known, environment="wall", **names)
    other = make(environment=environment, compensation="none", **names)
    seat_all(one)
    seat_all(other)
    for wave in white(1, dof):
        one.step(wave)
        other.step(wave)
        for name in ("x_s", "xd_s", "f_s", "v_s"):
            found, wanted = getattr(other, name)[0], getattr(one, name)[0]
            np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-11)
        if known == "one_step_delay":
            assert other.energies["potential"] == pytest.approx(one.energies["potential"])
    if known == "unwrapped":
        assert other.energies["late_decoding"] == pytest.approx(0.0, abs=1e-12)


def test_a_soft_body_pushes_by_its_law():
    """Pressed with F it yields d = (F/K)^(1/n)."""
    server = make(environment="hunt_crossley", k=3000.0)
    server.join(0, -0.032)
    for _ in range(4000):
        server.step([2.0 / (2.0 * B_W) ** 0.5])
    depth = (2.0 / 3000.0) ** (1.0 / 1.5)
    assert server.f_s[0] == pytest.approx(2.0)
    assert server.x_s[0] == pytest.approx(-0.03 + depth)
    assert server.energies["potential"] == pytest.approx(3000.0 * depth**2.5 / 2.5)
    for _ in range(400):
        server.step([-0.5])
    assert server.f_s[0] == 0.0


def test_a_slope_may_be_one_number():
    class Damper:
        def local(self, position, dt):
            return 0.0, 15.0

        def step(self, position, velocity, dt):
            return 15.0 * velocity

    server = make(around=Damper())
    server.join(0, 0.0)
    server.step([1.0])
    assert server.xd_s[0] == pytest.approx((2.0 * B_W) ** 0.5 / (B_W + 15.0))


class Told:
    """Writes down what it is told, and where its object is."""

    def __init__(self, **values):
        self.news, self.position, self.velocity = [], np.array([0.5]), np.array([0.0])
        vars(self).update(values)

    def join(self, user, position):
        self.news.append(("join", user, round(float(position[0]), 12)))

    def leave(self, user):
        self.news.append(("leave", user))

    def step(self, position, velocity, dt):
        self.news.append(dt)
        return 0.0 * velocity


def test_an_environment_is_told_of_joins_and_leaves_before_the_next_step():
    environment = Told()
    server = make(around=environment, users=2)
    server.join(1, 0.2)
    assert environment.news == []
    server.step([0.0, 0.0])
    server.leave(1)
    server.join(0, -0.1)
    server.step([0.0, 0.0])
    h = ServerParams().period_s
    assert environment.news == [("join", 1, 0.2), h, ("join", 0, -0.1), ("leave", 1), h]
    assert server.x_o == 0.5


class Faulty:
    """A damper that sometimes does something else."""

    def __init__(self, act):
        self.act, self.count = act, 0

    def step(self, position, velocity, dt):
        self.count += 1
        return self.act(velocity) if 10 < self.count <= 15 else 5.0 * velocity


def raises(error):
    def act(_):
        raise error

    return act


def scribble(velocity):
    velocity[0] = 1.0
    return velocity


@pytest.mark.parametrize(
    ("act", "words"),
    [
        (raises(ZeroDivisionError("no mass")), "raised ZeroDivisionError: no mass"),
        (raises(SystemExit("bye")), "raised SystemExit: bye"),
        (lambda v: v[0], "returned shape (1,) from step, not (2, 1)"),
        (lambda v: None, "from step"),
        (lambda v: v * np.nan, "for users [0, 1]"),
        (lambda v: v + np.array([[0.0], [np.inf]]), "for users [1]"),
        (lambda v: v + 1e30, "no usable force"),
        (lambda v: v * 1j, "returned complex numbers from step"),
        (scribble, "raised ValueError: assignment destination is read-only"),
    ],
)
def test_a_faulty_step_is_a_matched_damper_is_counted_and_named(act, words):
    server = make(around=Faulty(act), users=2)
    for user in (0, 1):
        server.join(user, 0.0)
    for n, wave in enumerate(white(2, 1, steps=30)):
        returned = server.step(wave)
        faulty = 10 <= n < 15
        assert server.f_s[1] == pytest.approx((B_W if faulty else 5.0) * server.xd_s[1])
        assert (returned[1] == 0.0) == faulty
    assert server.faults.steps == 5
    assert server.faults.text.startswith("server.environment = 'cube' ")
    assert words in server.faults.text
    accounts = server.energies
    assert accounts["contained"] > 0.0
    names = ("environment", "late_decoding", "withheld", "contained")
    assert sum(accounts[name] for name in names) == pytest.approx(server.taken_j)


class Lost(Told):
    """Cannot say where its object is."""

    @property
    def position(self):
        raise KeyError("object")

    @position.setter
    def position(self, value): ...


@pytest.mark.parametrize(
    ("environment", "words"),
    [
        (Lost(), "raised KeyError: 'object'"),
        (Told(position=np.zeros(5)), "otherwise than by an array (1,)"),
        (Told(position=np.array([np.nan])), "must be finite"),
        (Told(energy=np.inf), "gave energy = inf: must be finite"),
    ],
)
def test_the_other_answers_of_an_environment_are_checked_too(environment, words):
    server = make(around=environment)
    server.join(0, 0.0)
    assert server.step([1.0]) == [0.0]
    assert words in server.faults.text


def test_energy_below_zero_is_none():
    server = make(around=Told(energy=-3.0))
    server.join(0, 0.0)
    server.step([1.0])
    assert server.energies["potential"] == 0.0
    assert server.faults.steps == 0


def test_no_answer_is_contained_and_the_news_are_kept():
    environment, busy = Told(), [True]

    def call(exchange):
        if busy[0]:
            raise Unanswered("is still busy")
        return exchange()

    server = make(around=environment, call=call)
    server.join(0, 0.0)
    assert server.step([1.0]) == [0.0]
    assert server.faults.text == "server.environment = 'cube' is still busy"
    busy[0] = False
    assert server.step([1.0]) == [1.0]
    assert environment.news[0] == ("join", 0, 0.0)
