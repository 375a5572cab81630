# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The points of contact of a box: no energy from any motion, slopes against differences."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from property.test_box import H, box

from pmwvc_core.scenes.kinematics import Poses, by_velocities, moved, points_at, slope_of
from pmwvc_core.scenes.pressing import Points, pressed, stored_j


def points(rng, count):
    """Return points of any state over any surface."""
    normal = rng.normal(size=(count, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    bristle = rng.normal(0.0, 1e-3, (count, 3))
    bristle -= np.sum(bristle * normal, axis=1, keepdims=True) * normal
    return Points(
        normal, rng.normal(0.0, 1e-3, count), bristle, 10 ** rng.uniform(2.0, 6.0, count),
        rng.choice([0.0, 10.0], count), rng.uniform(0.0, 1.5, count), rng.random(count) < 0.9,
    )  # fmt: skip


@given(seed=st.integers(0, 2**32 - 1))
def test_a_point_makes_no_energy_whatever_its_motion(seed):
    """With the control: the force at the beginning of the step makes some."""
    rng = np.random.default_rng(seed)
    p, motion = points(rng, 40), rng.normal(0.0, 1e-3, (40, 3))
    scale_j = float(np.sum(p.stiffness) * 1e-6)
    force = pressed(p, motion, H)
    after = p._replace(depth=p.depth - np.sum(p.normal * motion, axis=1), bristle=force.bristle)
    assert np.sum(force.force * motion) - stored_j(after) + stored_j(p) > -1e-12 * scale_j
    cone = np.linalg.norm(force.force + force.pressing[:, None] * p.normal, axis=1)
    assert (cone <= p.friction * force.pressing + 1e-9).all()
    still = pressed(p._replace(damping=0.0 * p.damping), 0.0 * motion, H).force
    depth = p.depth - np.sum(p.normal * motion, axis=1)
    smooth = p._replace(friction=0.0 * p.friction, bristle=0.0 * p.bristle)
    gained_j = stored_j(smooth._replace(depth=depth)) - stored_j(smooth)
    pushed_j = np.sum(still * p.normal * np.sum(p.normal * motion, axis=1)[:, None])
    assert pushed_j - gained_j < 0.0


@given(seed=st.integers(0, 2**32 - 1))
def test_the_slope_of_a_point_is_that_of_its_force(seed):
    rng = np.random.default_rng(seed)
    p, motion = points(rng, 20), rng.normal(0.0, 1e-3, (20, 3))
    change = rng.normal(0.0, 1e-10, (20, 3))
    middle = pressed(p, motion, H)
    ends = [pressed(p, motion + sign * change, H).force for sign in (1.0, -1.0)]
    expected = (middle.slope @ change[:, :, None])[:, :, 0]
    near = np.abs(0.5 * (ends[0] - ends[1]) - expected).max(axis=1)
    assert np.median(near / (1e-12 + np.abs(expected).max(axis=1))) < 1e-3  # off the edges


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_newtons_slope_is_that_of_the_forces(seed):
    """Against differences, of pads that stick and corners that press, while the box turns; the
    control is the slope as if J did not turn with it.
    """
    rng, made = np.random.default_rng(seed), box(friction=5.0)
    shape, k = made._shape, 6 + 2 * 6
    start = Poses(1e-4 * rng.normal(size=(3, 3)) + made._poses.at, made._poses.turned)
    at = points_at(start, shape)
    begun = made._points._replace(depth=np.full(len(at), 1e-2), can_touch=np.ones(len(at), bool))
    rates = rng.normal(0.0, 0.01, k)
    rates[3:6] = rng.normal(0.0, 1.0, 3)

    def forces(x):
        poses = moved(start, x, H, shape)
        mean = Poses(*(0.5 * (a + b) for a, b in zip(start, poses, strict=True)))
        by = by_velocities(mean, shape)
        after = pressed(begun, points_at(poses, shape) - at, H)
        return after.force.ravel() @ by.reshape(-1, k), (after, by, x[3:6], mean, H, shape)

    step = 1e-6 * rng.normal(size=k)
    change = 0.5 * (forces(rates + step)[0] - forces(rates - step)[0])
    after, by, *about = forces(rates)[1]
    rows = by.reshape(-1, k)
    still = H * rows.T @ (after.slope @ by).reshape(rows.shape) @ step
    missed = np.linalg.norm(slope_of(after, by, *about) @ step - change)
    assert missed < 0.3 * np.linalg.norm(still - change)
