# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Contact laws: numbers by hand, and the one-sided law against its own equation."""

from fractions import Fraction

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from pmwvc_core.law.server.contacts import (
    advanced_contact,
    attached,
    contact_energy,
    contact_force,
    contact_unwrapped,
    detached,
    offset_of,
    slid,
    touching,
)
from pmwvc_core.law.server.springs import spring_answer
from pmwvc_core.made.server import contact_of
from pmwvc_core.params import ContactParams

H = 0.008
LEFT, RIGHT = -1, 1


class Held:
    """A contact with its state, on floats where there is one axis."""

    def __init__(self, kind, k, damping, *, side=LEFT, gap=0.0, axes=1):
        params = ContactParams(
            contact=kind, contact_stiffness=k, contact_damping=damping, gap_m=gap
        )
        self.c = contact_of(params, side=side, size=0.06, axes=axes)

    def attach(self, *offset):
        self.c = attached(self.c, offset)

    def slide(self, *way):
        self.c, dropped_j = slid(self.c, way)
        return dropped_j

    def detach(self):
        self.c, dropped_j = detached(self.c)
        return dropped_j

    def force(self, *rate):
        f = contact_force(self.c, rate)
        return f[0] if len(f) == 1 else f

    def answer(self, free, b, h):
        return spring_answer(self.c.springs[0], free, b, h, touching(self.c), self.c.law)

    def advance(self, answer, h):
        self.c, heat_j = advanced_contact(self.c, (answer.force,), (answer.rate,), h)
        return heat_j

    def unwrapped(self, free, xd_o, b, weight):
        return contact_unwrapped(self.c, (free,), (xd_o,), b, weight)[0]

    energy = property(lambda self: contact_energy(self.c))
    touching = property(lambda self: touching(self.c))

    @property
    def position(self):
        place = offset_of(self.c)
        return place[0] if len(place) == 1 else place


def bilateral():
    return Held("bilateral", 500.0, 10.0)


def grip(side=LEFT, *, k=500.0, damping=10.0, gap=0.0, depth=None):
    contact = Held("grip", k, damping, side=side, gap=gap)
    if depth is not None:
        [spring] = contact.c.springs
        contact.c = contact.c._replace(springs=(spring._replace(deflection=-side * depth),))
    return contact


def test_a_two_sided_contact_pushes_and_pulls():
    contact = bilateral()
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


@pytest.mark.parametrize("make", [bilateral, grip])
def test_letting_go_drops_the_energy_of_the_spring(make):
    contact = make()
    contact.attach(-0.03)
    contact.slide(0.004)
    stored = contact.energy
    assert stored == pytest.approx(0.5 * 500.0 * 0.004**2)
    assert contact.detach() == stored
    assert contact.energy == 0.0


def test_an_unwrapped_force_fits_the_velocity_it_leaves():
    contact, free, xd_o, b, weight = bilateral(), 0.3, 0.05, 25.0, 0.004
    contact.slide(0.002)
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
    least = 1e-300  # products below it round in steps of their own size
    assert low.force <= here.force + least and here.force <= high.force + least
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


class TestInSpace:
    """A grip along axis 0 that also holds on sideways."""

    def make(self):
        contact = Held("grip", 500.0, 10.0, axes=3)
        contact.attach(-0.03, 0.01, -0.01)
        return contact

    def test_nothing_holds_before_contact(self):
        contact = self.make()
        contact.slide(-0.001, 0.02, 0.02)
        assert contact.force(0.0, 1.0, 1.0) == (0.0, 0.0, 0.0)
        assert contact.position == pytest.approx((-0.031, 0.03, 0.01))

    def test_contact_anchors_where_it_begins(self):
        contact = self.make()
        contact.slide(0.002, 0.02, 0.0)
        assert contact.force(0.0, 0.0, 0.0) == pytest.approx((1.0, 0.0, 0.0))
        contact.slide(0.0, 0.001, -0.002)
        assert contact.force(0.0, 0.0, 0.0) == pytest.approx((1.0, 0.5, -1.0))
        assert contact.position == pytest.approx((-0.028, 0.031, -0.012))

    def test_coming_out_drops_the_sideways_spring(self):
        contact = self.make()
        contact.slide(0.002, 0.0, 0.0)
        contact.slide(0.0, 0.003, 0.004)
        assert contact.slide(-0.003, 0.0, 0.0) == pytest.approx(0.5 * 500.0 * 0.005**2)
        assert contact.energy == 0.0
        assert contact.position == pytest.approx((-0.031, 0.013, -0.006))
