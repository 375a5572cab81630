# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Motions of the exact model that are no instability: translations, and all going on together.
That they are those of the simulator: ``test_multirate_model.py``.
"""

import numpy as np
import pytest
from support import linear_loops

from pmwvc_analysis.models.linearize import Linear, build, spectral_radius
from pmwvc_analysis.models.loop import loop_of

RIGID = [
    ({}, 4),  # two devices and the cube each somewhere else, and all moving on
    ({"device__damping": 1.0}, 3),
    ({"server__object_damping": 1.0}, 3),
    ({"server__environment": "wall"}, 2),
    ({"users": 5}, 7),
    ({"controller": "direct"}, 2),
    ({"controller": "direct", "server__environment": "wall"}, 0),
    ({"server__contact_stiffness": 0.0}, 6),
    ({"server__contact_stiffness": 0.0, "server__contact_damping": 0.0}, 8),
    ({"controller": "virtual_coupling"}, 1),
    ({"controller": "virtual_coupling", "server__environment": "wall"}, 0),
    ({"controller": "virtual_coupling", "server__contact_stiffness": 0.0}, 3),
    ({"master__bank__kind": "complementary"}, 4),
    ({"master__bank__kind": "complementary", "master__local_model__stiffness": 0.0}, 6),
    ({"master__velocity_filter__kind": "exact", "master__velocity_filter__cutoff_hz": 15.0}, 4),
]


@pytest.mark.parametrize(("values", "modes"), RIGID)
def test_motions_that_are_no_instability_are_exact_and_counted(values, modes):
    scenario = linear_loops.scenario(
        user1__link__up__delay_s=0.008,
        user2__link__down__delay_s=0.016,
        user1__server__impedance=14.0,
        **{"server__contact_stiffness": 40.0} | values,
    )
    model = Linear(loop_of(scenario))
    (left,), motions = model.quotient
    assert motions == modes
    # What is left to be zero shows in the eigenvalues that the quotient takes away.
    ones = (np.sum(np.abs(np.linalg.eigvals(a) - 1.0) < 1e-3) for a in (model.matrices[0], left))
    assert next(ones) - next(ones) == modes
    assert spectral_radius(build(scenario)) < 1.0


def tied(**values):
    return linear_loops.scenario(
        master__position__feedback="printed", master__position__gain=15.0, **values
    )


@pytest.mark.parametrize(
    ("values", "modes"),
    [
        ({}, 1),  # all together
        ({"user2__master__position__gain": 0.0}, 2),  # user2's device by itself
        ({"server__environment": "wall"}, 0),
        ({"server__environment": "wall", "server__contact_stiffness": 0.0}, 2),
        ({"master__rate_drop": 1, "server__period_s": 0.001}, 2),  # and moving on
        ({"master__rate_drop": 1, "server__period_s": 0.001, "user1__server__impedance": 14.0}, 1),
    ],
)
def test_a_position_feedback_ties_devices_to_their_avatars(values, modes):
    _, motions = Linear(loop_of(tied(link__delay_s=0.008, **values))).quotient
    assert motions == modes


def test_the_published_position_feedback_drives_a_free_cube():
    assert spectral_radius(build(tied(link__delay_s=0.008))) > 1.0 + 1e-5
    at_a_wall = tied(link__delay_s=0.008, server__environment="wall")
    assert spectral_radius(build(at_a_wall)) < 1.0
