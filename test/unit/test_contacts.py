# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Contact laws: numbers by hand, and the one-sided law against its own equation."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from pmwvc_core.errors import ParameterError
from pmwvc_core.params import ContactParams
from pmwvc_core.server.contacts import Bilateral
from pmwvc_core.server.factory import make_contact
from pmwvc_core.server.friction import AnchoredGrip
from pmwvc_core.server.grip import Grip

H = 0.008
LEFT, RIGHT = -1, 1


def grip(side=LEFT, *, k=500.0, damping=10.0, size=0.06, gap=0.0, depth=None):
    contact = Grip(k, damping, side=side, size=size, gap=gap)
    if depth is not None:
        contact.deflection = -side * depth
    return contact


def test_a_two_sided_contact_pushes_and_pulls():
    contact = Bilateral(500.0, 10.0)
    contact.attach(0.04)
    assert contact.force(0.0) == 0.0
    contact.slide(0.002)
    assert contact.force(0.1) == pytest.approx(2.0)
    contact.slide(-0.004)
    assert contact.force(0.0) == pytest.approx(-1.0)
    assert contact.energy == pytest.approx(0.001)
    assert contact.position == pytest.approx(0.038)


@pytest.mark.parametrize("side", [LEFT, RIGHT])
def test_a_grip_pushes_inwards_only(side):
    inwards = -side
    assert grip(side, depth=0.002).force(0.0) == pytest.approx(inwards * 1.0)
    assert grip(side, depth=0.002).force(inwards * 0.1) == pytest.approx(inwards * 2.0)
    assert grip(side, depth=0.002).force(-inwards * 0.5) == 0.0
    assert grip(side, depth=-0.002).force(inwards * 5.0) == 0.0


@pytest.mark.parametrize("side", [LEFT, RIGHT])
def test_a_grip_begins_outside_the_face_by_the_gap(side):
    face = side * 0.03
    contact = grip(side, gap=0.004)
    contact.attach(0.0)  # in the middle of the object
    assert contact.position == pytest.approx(face + side * 0.004)
    contact.attach(face + side * 0.01)  # far enough away: stays where it is
    assert contact.position == pytest.approx(face + side * 0.01)
    assert not contact.touching
    assert contact.energy == 0.0


@pytest.mark.parametrize("make", [lambda: Bilateral(500.0, 10.0), grip])
def test_letting_go_drops_the_energy_of_the_spring(make):
    contact = make()
    contact.attach(-0.03)
    contact.slide(0.004)
    stored = contact.energy
    assert stored == pytest.approx(0.5 * 500.0 * 0.004**2)
    assert contact.detach() == stored
    assert contact.energy == 0.0


def test_an_unwrapped_force_fits_the_velocity_it_leaves():
    contact, free, xd_o, b, weight = Bilateral(500.0, 10.0), 0.3, 0.05, 25.0, 0.004
    contact.deflection = 0.002
    force = contact.unwrapped(free, xd_o, b, weight)
    xd = free - force / b
    assert force == pytest.approx(500.0 * (0.002 + weight * xd) + 10.0 * (xd - xd_o))
    pressed = grip(depth=0.002)
    assert pressed.unwrapped(free, xd_o, b, weight) == pytest.approx(force)
    assert pressed.unwrapped(-5.0, xd_o, b, weight) == 0.0
    assert grip(depth=-0.02).unwrapped(free, xd_o, b, weight) == 0.0


def mean_push(p0, rate, k, damping):
    """Return the mean force over a step by its definition, in exact numbers."""
    h, p0, rate, k, damping = map(Fraction, (H, p0, rate, k, damping))
    p1 = p0 + h * rate
    inside_0, inside_1 = max(p0, Fraction(0)), max(p1, Fraction(0))
    if p1 == p0:
        return max(0.0, float(k * inside_0))
    spring = k / 2 * (inside_1**2 - inside_0**2) / (p1 - p0)
    return max(0.0, float(spring + damping * (inside_1 - inside_0) / h))


@given(
    p0=st.floats(-0.02, 0.02),
    free=st.floats(-3.0, 3.0),
    k=st.one_of(st.just(0.0), st.floats(1.0, 1e5)),
    damping=st.one_of(st.just(0.0), st.floats(0.1, 100.0)),
    b=st.floats(1.0, 100.0),
    side=st.sampled_from([LEFT, RIGHT]),
)
def test_the_mean_force_of_a_grip_solves_its_equation(p0, free, k, damping, b, side):
    contact = grip(side, k=k, damping=damping, depth=p0)
    answer = contact.answer(-side * free, b, H)
    push, rate = -side * answer.force, -side * answer.rate
    assert push >= 0.0
    assert rate == pytest.approx(free - push / b, abs=1e-12)
    # The force is steep in the rate, by up to k h/2 + damping: bracket it.
    slack, rounding = 1e-12 * (1.0 + abs(rate)), 1e-12 * (1.0 + push)
    assert mean_push(p0, rate - slack, k, damping) <= push + rounding
    assert mean_push(p0, rate + slack, k, damping) >= push - rounding


@given(
    p0=st.floats(-0.02, 0.02),
    free=st.floats(-3.0, 3.0),
    k=st.floats(1.0, 1e5),
    damping=st.one_of(st.just(0.0), st.floats(0.1, 100.0)),
)
def test_the_slope_of_a_grip_is_the_fall_of_its_force(p0, free, k, damping):
    b, step = 25.0, 1e-6
    contact = grip(LEFT, k=k, damping=damping, depth=p0)
    low, here, high = (contact.answer(free + d, b, H) for d in (-step, 0.0, step))
    assert low.force <= here.force <= high.force
    assert 0.0 <= here.slope <= b
    if abs(high.slope - low.slope) <= 1e-3 * here.slope:  # not at a corner of the law
        measured = (high.force - low.force) / (2 * step)
        assert here.slope == pytest.approx(measured, rel=1e-2, abs=1e-2)


@given(
    p0=st.floats(-0.02, 0.02),
    free=st.floats(-3.0, 3.0),
    k=st.floats(1.0, 1e5),
    damping=st.one_of(st.just(0.0), st.floats(0.1, 100.0)),
)
@example(p0=3e-164, free=1.0, k=5581.0, damping=0.0)  # its square vanishes
@example(p0=-2e-308, free=0.0, k=1.0, damping=0.0)
def test_what_a_grip_takes_in_is_stored_or_heats(p0, free, k, damping):
    contact = grip(LEFT, k=k, damping=damping, depth=p0)
    before = contact.energy
    answer = contact.answer(free, 25.0, H)
    heat = contact.advance(answer, H)
    work = H * answer.force * answer.rate
    scale = before + contact.energy + abs(work)
    assert heat >= -1e-13 * scale
    assert work == pytest.approx(contact.energy - before + heat, abs=1e-12 * scale + 1e-15)


def test_a_grip_that_is_pulled_off_fast_gives_no_energy_back():
    contact = grip(depth=0.002)
    before = contact.energy
    answer = contact.answer(-1.0, 25.0, H)
    assert answer.force == 0.0
    assert contact.advance(answer, H) == pytest.approx(before)


class TestInSpace:
    """A grip along axis 0 that also holds on sideways."""

    def make(self, *, runs=None):
        contact = AnchoredGrip(grip(), dof=3)
        start = np.array([-0.03, 0.01, -0.01])
        contact.attach(start if runs is None else np.tile(start, (runs, 1)))
        return contact

    def place(self, contact):
        return contact.position

    def test_nothing_holds_before_contact(self):
        contact = self.make()
        contact.slide(np.array([-0.001, 0.02, 0.02]))
        np.testing.assert_array_equal(contact.force(np.array([0.0, 1.0, 1.0])), 0.0)
        np.testing.assert_allclose(self.place(contact), [-0.031, 0.03, 0.01])

    def test_contact_anchors_where_it_begins(self):
        contact = self.make()
        contact.slide(np.array([0.002, 0.02, 0.0]))
        np.testing.assert_allclose(contact.force(np.zeros(3)), [1.0, 0.0, 0.0])
        contact.slide(np.array([0.0, 0.001, -0.002]))
        np.testing.assert_allclose(contact.force(np.zeros(3)), [1.0, 0.5, -1.0])
        np.testing.assert_allclose(self.place(contact), [-0.028, 0.031, -0.012])

    def test_coming_out_drops_the_sideways_spring(self):
        contact = self.make()
        contact.slide(np.array([0.002, 0.0, 0.0]))
        contact.slide(np.array([0.0, 0.003, 0.004]))
        dropped = contact.slide(np.array([-0.003, 0.0, 0.0]))
        np.testing.assert_allclose(dropped, 0.5 * 500.0 * 0.005**2)
        np.testing.assert_array_equal(contact.energy, 0.0)
        np.testing.assert_allclose(self.place(contact), [-0.031, 0.013, -0.006])

    def test_each_run_of_a_batch_holds_by_itself(self):
        contact = self.make(runs=2)
        contact.slide(np.array([[0.002, 0.0, 0.0], [-0.002, 0.0, 0.0]]))
        contact.slide(np.array([[0.0, 0.001, 0.0], [0.0, 0.001, 0.0]]))
        np.testing.assert_array_equal(contact.touching, [[True], [False]])
        expected = [[1.0, 0.5, 0.0], [0.0, 0.0, 0.0]]
        np.testing.assert_allclose(contact.force(np.zeros((2, 3))), expected)


def test_floats_stay_floats():
    for contact in (Bilateral(500.0, 10.0), grip(depth=0.001)):
        answer = contact.answer(0.3, 25.0, H)
        parts = (answer.force, answer.rate, answer.slope, contact.advance(answer, H))
        parts = (*parts, contact.energy, contact.force(0.1))
        assert all(type(part) is float for part in parts)


def test_the_factory_follows_name_and_axes():
    bilateral = ContactParams(contact="bilateral")
    assert isinstance(make_contact(bilateral, side=1, size=0.06, dof=3), Bilateral)
    assert isinstance(make_contact(ContactParams(), side=1, size=0.06, dof=1), Grip)
    assert isinstance(make_contact(ContactParams(), side=1, size=0.06, dof=2), AnchoredGrip)
    with pytest.raises(ParameterError, match=r"side = 0: must be -1 .* or \+1"):
        make_contact(ContactParams(), side=0, size=0.06, dof=1)
