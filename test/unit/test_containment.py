# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The calls of a black-box environment, and the containment of its faults."""

import numpy as np
import pytest
from support.law_rigs import Users

from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.plugins import Unanswered

B_W = 25.0


def around(environment, *, users=1, call=None, **values):
    """A port around an environment that has no name."""
    contacts = [ContactParams(contact="bilateral")] * users
    options = {} if call is None else {"call": call}
    server = ServerParams(coupling="unknown", **values)
    return Users(server, contacts, environment=environment, **options)


def white(users, dof, *, steps=200, size=0.5, seed=3):
    rng = np.random.default_rng(seed)
    for _ in range(steps):
        rows = rng.normal(0.0, size, (users, dof))
        yield [float(row[0]) if dof == 1 else row for row in rows]


class Told:
    """Writes down what it is told, and where its object is."""

    def __init__(self):
        self.news, self.position, self.velocity = [], np.array([0.5]), np.array([0.0])

    def join(self, user, position):
        self.news.append(("join", user, round(float(position[0]), 12)))

    def leave(self, user):
        self.news.append(("leave", user))

    def step(self, position, velocity, dt):
        self.news.append(dt)
        return 0.0 * velocity


def test_an_environment_is_notified_of_joins_and_leaves_before_the_next_step():
    environment = Told()
    server = around(environment, users=2)
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


def boom(_):
    raise ZeroDivisionError("no mass")


def leave(_):
    raise SystemExit("bye")


def scribble(velocity):
    velocity[0] = 1.0
    return velocity


@pytest.mark.parametrize(
    ("act", "text"),
    [
        (boom, "raised ZeroDivisionError: no mass"),
        (lambda v: v[0], r"returned shape \(1,\) from step, not \(2, 1\)"),
        (lambda v: None, r"returned NoneType from step|returned shape \(\) from step"),
        (lambda v: v * np.nan, r"no usable force .* for users \[0, 1\]"),
        (lambda v: v + np.array([[0.0], [np.inf]]), r"no usable force .* for users \[1\]"),
        (lambda v: v + 1e30, "no usable force"),
        (leave, "raised SystemExit: bye"),
        (lambda v: v * 1j, "returned complex numbers from step"),
        (scribble, "raised ValueError: assignment destination is read-only"),
    ],
)
def test_a_faulty_step_is_a_matched_damper_is_counted_and_named(act, text):
    server = around(Faulty(act), users=2)
    for user in (0, 1):
        server.join(user, 0.0)
    waves = list(white(2, 1, steps=30))
    for n, wave in enumerate(waves):
        returned = server.step(wave)
        if 10 <= n < 15:
            assert returned[1] == 0.0
            assert server.f_s[1] == pytest.approx(B_W * server.xd_s[1])
        else:
            assert server.f_s[1] == pytest.approx(5.0 * server.xd_s[1])
    assert server.faults.steps == 5
    with pytest.raises(AssertionError, match=rf"server.environment = 'cube' .*({text})"):
        raise AssertionError(server.faults.text)
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
    ("environment", "text"),
    [
        (Lost, "raised KeyError: 'object'"),
        (lambda: with_attributes(position=np.zeros(5)), r"otherwise than by an array \(1,\)"),
        (lambda: with_attributes(position=np.array([np.nan])), "must be finite"),
        (lambda: with_attributes(energy=np.inf), "gave energy = inf: must be finite"),
    ],
)
def test_the_other_answers_of_an_environment_are_checked_too(environment, text):
    server = around(environment())
    server.join(0, 0.0)
    assert server.step([1.0]) == [0.0]
    with pytest.raises(AssertionError, match=text):
        raise AssertionError(server.faults.text)


def with_attributes(**values):
    environment = Told()
    for name, value in values.items():
        setattr(environment, name, value)
    return environment


def test_energy_below_zero_is_none():
    server = around(with_attributes(energy=-3.0))
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

    server = around(environment, call=call)
    server.join(0, 0.0)
    assert server.step([1.0]) == [0.0]
    assert server.faults.text == "server.environment = 'cube' is still busy"
    busy[0] = False
    assert server.step([1.0]) == [1.0]
    assert environment.news[0] == ("join", 0, 0.0)
