# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Contact laws, and the shared object under held forces and by the midpoint rule."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.linalg import expm

from pmwvc_core.law.motion import (
    Body,
    body_law,
    drifted,
    imbalance,
    kinetic_j,
    mobility,
    pushed_body,
)
from pmwvc_core.law.server.contacts import (
    advanced_contact,
    attached,
    contact_energy,
    contact_force,
    offset_of,
    slid,
    touching,
)
from pmwvc_core.law.server.springs import spring_answer
from pmwvc_core.made.server import contact_of
from pmwvc_core.params import ContactParams

H, B = 0.008, 25.0
LEFT, RIGHT = SIDES = -1, 1
depths, rates = st.floats(-0.02, 0.02), st.floats(-3.0, 3.0)
dampings = st.just(0.0) | st.floats(0.1, 100.0)


def made(kind="grip", k=500.0, damping=10.0, *, side=LEFT, gap=0.0, axes=1, depth=None):
    """Return a contact, so deep in its face."""
    params = ContactParams(contact=kind, contact_stiffness=k, contact_damping=damping, gap_m=gap)
    c = contact_of(params, side=side, size=0.06, axes=axes)
    if depth is None:
        return c
    return c._replace(springs=(c.springs[0]._replace(deflection=-side * depth),))


def moved(c, *way):
    return slid(c, way)[0]


def answered(c, free, b=B):
    return spring_answer(c.springs[0], free, b, H, touching(c), c.law)


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
    p0=depths, free=rates, k=st.just(0.0) | st.floats(1.0, 1e5), damping=dampings,
    b=st.floats(1.0, 100.0), side=st.sampled_from(SIDES),
)  # fmt: skip
def test_the_mean_force_of_a_grip_solves_its_equation(p0, free, k, damping, b, side):
    answer = answered(made("grip", k, damping, side=side, depth=p0), -side * free, b)
    push, rate = -side * answer.force, -side * answer.rate
    assert push >= 0.0
    assert rate == pytest.approx(free - push / b, abs=1e-12)
    # The force is steep in the rate, by up to k h/2 + damping: bracket it.
    slack, rounding = 1e-12 * (1.0 + abs(rate)), 1e-12 * (1.0 + push)
    assert mean_push(p0, rate - slack, k, damping) <= push + rounding
    assert mean_push(p0, rate + slack, k, damping) >= push - rounding


@given(p0=depths, free=rates, k=st.floats(1.0, 1e5), damping=dampings)
@example(p0=3e-164, free=1.0, k=5581.0, damping=0.0)  # its square vanishes
@example(p0=-2e-308, free=0.0, k=1.0, damping=0.0)
@example(p0=0.002, free=-1.0, k=500.0, damping=10.0)  # pulled off fast
def test_slope_and_energy_of_a_grip(p0, free, k, damping):
    """The slope is the fall of its force; what it takes in is stored or heats."""
    step, c = 1e-6, made("grip", k, damping, depth=p0)
    low, here, high = (answered(c, free + d) for d in (-step, 0.0, step))
    least = 1e-300  # products below it round in steps of their own size
    assert low.force <= here.force + least and here.force <= high.force + least
    assert 0.0 <= here.slope <= B
    if abs(high.slope - low.slope) <= 1e-3 * here.slope:  # not at a corner of the law
        measured = (high.force - low.force) / (2 * step)
        assert here.slope == pytest.approx(measured, rel=1e-2, abs=1e-2)
    after, heat_j = advanced_contact(c, (here.force,), (here.rate,), H)
    before_j, after_j, work_j = (
        contact_energy(c),
        contact_energy(after),
        H * here.force * here.rate,
    )
    scale = before_j + after_j + abs(work_j)
    assert heat_j >= -1e-13 * scale
    assert work_j == pytest.approx(after_j - before_j + heat_j, abs=1e-12 * scale + 1e-15)


@pytest.mark.parametrize("side", SIDES)
def test_a_grip_begins_outside_the_face_by_the_gap(side):
    face = side * 0.03
    middle = attached(made(side=side, gap=0.004), (0.0,))  # of the object
    assert offset_of(middle) == pytest.approx((face + side * 0.004,))
    far = attached(middle, (face + side * 0.01,))  # far enough away: stays where it is
    assert offset_of(far) == pytest.approx((face + side * 0.01,))
    assert not touching(far) and contact_energy(far) == 0.0


def test_a_grip_holds_sideways_from_where_it_touched_until_it_comes_out():
    outside = attached(made(axes=3), (-0.03, 0.01, -0.01))
    away = moved(outside, -0.001, 0.02, 0.02)
    assert contact_force(away, (0.0, 1.0, 1.0)) == (0.0, 0.0, 0.0)
    assert offset_of(away) == pytest.approx((-0.031, 0.03, 0.01))
    c = moved(outside, 0.002, 0.02, 0.0)
    assert contact_force(c, (0.0,) * 3) == pytest.approx((1.0, 0.0, 0.0))
    c = moved(c, 0.0, 0.001, -0.002)
    assert contact_force(c, (0.0,) * 3) == pytest.approx((1.0, 0.5, -1.0))
    assert offset_of(c) == pytest.approx((-0.028, 0.031, -0.012))
    c, dropped_j = slid(c, (-0.003, 0.0, 0.0))
    assert dropped_j == pytest.approx(0.5 * 500.0 * (0.001**2 + 0.002**2))
    assert contact_energy(c) == 0.0
    assert offset_of(c) == pytest.approx((-0.031, 0.031, -0.012))


STEP_S = 0.008
LEAST = 1e-290  # products below it round in steps of their own size
masses = st.floats(0.01, 50.0)
drags = st.one_of(st.just(0.0), st.floats(1e-9, 200.0))


@given(mass=masses, damping=drags, force=st.floats(-20.0, 20.0), start=st.floats(-1.0, 1.0))
def test_a_held_force_moves_the_cube_as_the_matrix_exponential_gives(mass, damping, force, start):
    """The ground takes energy only, without damping none."""
    law, before = body_law(mass, damping, STEP_S), Body((0.0,), (start,))
    generator = np.zeros((3, 3))
    generator[0, 1], generator[1, 1], generator[1, 2] = 1.0, -damping / mass, 1.0 / mass
    x, xd, _ = expm(STEP_S * generator) @ [0.0, start, force]
    after, (moved,), lost_j = pushed_body(before, (force,), law)
    assert moved == after.x[0] == pytest.approx(x, rel=1e-10, abs=1e-13)
    assert after.xd[0] == pytest.approx(xd, rel=1e-10, abs=1e-12)
    scale = LEAST + kinetic_j(before, law) + kinetic_j(after, law) + abs(force * moved)
    assert lost_j >= -1e-13 * scale
    if damping == 0.0:
        assert lost_j == pytest.approx(0.0, abs=1e-13 * scale)


@given(mass=masses, damping=drags, force=st.floats(-20.0, 20.0), start=st.floats(-1.0, 1.0))
def test_the_midpoint_step_balances_work_motion_and_ground(mass, damping, force, start):
    law, before = body_law(mass, damping, STEP_S), Body((0.0,), (start,))
    velocity = start - imbalance(start, start, force, law) * mobility(0.0, law)
    missing = imbalance(start, velocity, force, law)
    assert missing == pytest.approx(0.0, abs=1e-12 * (abs(force) + 2 * mass / STEP_S))
    after, lost_j = drifted(before, (velocity,), law)
    work, gained_j = STEP_S * force * velocity, kinetic_j(after, law) - kinetic_j(before, law)
    scale = LEAST + kinetic_j(before, law) + kinetic_j(after, law) + abs(work) + lost_j
    assert work == pytest.approx(gained_j + lost_j, abs=1e-12 * scale)
    assert after.x == (STEP_S * velocity,)


def test_a_wall_does_not_give_way():
    wall, law = Body((0.0,), (0.0,)), body_law(float("inf"), 0.0, STEP_S)
    assert pushed_body(wall, (1e3,), law) == (wall, (0.0,), 0.0)
    assert drifted(wall, (0.0,), law) == (wall, 0.0)
    assert (mobility(3.0, law), kinetic_j(wall, law)) == (0.0, 0.0)
