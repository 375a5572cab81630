# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The exact model (the laws on the identity) against the one written out by hand.

Random scenarios with every linear coupling, filter, hold, port filter, rate drop, server period
and delay. Defective eigenvalues are sensitive as a root of rounding, so spectra are compared by
their power sums, trace(A^k) on the quotient by rigid motions, and by their radius.
"""

import dataclasses

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from oracle import linear_model
from support import linear_loops

from pmwvc_analysis.models import elements, loop
from pmwvc_analysis.models.hyperperiod import Hyperperiod
from pmwvc_analysis.models.linear import NonlinearError
from pmwvc_analysis.models.linearize import kept_loop, linearize
from pmwvc_analysis.models.stability import radii
from pmwvc_analysis.models.variation import subproblems
from pmwvc_core.errors import ParameterError
from pmwvc_core.law.port import master
from pmwvc_core.law.user_tick import user_tick

BLACK_BOX = {"server__coupling": "unknown", "server__compensation": "none"}
CONTROLLERS = [
    *({"server__coupling": name} for name in ("implicit", "one_step_delay", "one_frame_late")),
    {"server__coupling": "unwrapped", "server__integrator": "trapezoid"},
    {"server__coupling": "unwrapped", "server__integrator": "forward_euler"},
    BLACK_BOX | {"server__environment": "wall", "server__decoding": "late"},
    BLACK_BOX | {"server__environment": "wall_with_slope"},
    BLACK_BOX | {"server__environment": "cube", "server__decoding": "late"},
    {"controller": "direct"},
    {"controller": "virtual_coupling"},
]
FILTERS = [
    {"kind": "none", "pole_rad_s": None},
    {"kind": "first_order", "pole_rad_s": 50.0},
    {"kind": "butterworth", "pole_rad_s": None, "pass_hz": 20.0, "stop_hz": 60.0},
    {"kind": "integrate_and_dump", "pole_rad_s": None},
]
AROUND = [
    {},
    *(
        {"velocity_filter__kind": kind, "velocity_filter__cutoff_hz": 30.0}
        for kind in ("exact", "complementary", "equivalent")
    ),
    {"bank__kind": "dissertation", "local_model__damping": 2.0},
    {"bank__kind": "complementary", "local_model__stiffness": 0.0},
    {"position__feedback": "printed", "position__gain": 2.0},
]


@st.composite
def scenarios(draw):
    """Draw a scenario of two users and whether it is live."""
    master = {f"filter__{name}": v for name, v in draw(st.sampled_from(FILTERS)).items()}
    master |= draw(st.sampled_from(AROUND)) | {"hold": draw(st.sampled_from(["zoh", "foh"]))}
    # b = B returns no wave: the program leaves out what nothing reaches, the other model does not.
    master["impedance"] = draw(st.floats(5.0, 60.0, exclude_min=True))
    values = {f"master__{name}": value for name, value in master.items()}
    values |= draw(st.sampled_from(CONTROLLERS))
    values |= {
        "server__period_s": draw(st.sampled_from([4e-3, 6e-3, 8e-3])),
        "server__contact_stiffness": draw(st.sampled_from([0.0, 40.0, 800.0])),
        "server__contact_damping": draw(st.sampled_from([0.0, 5.0])),
        "server__object_damping": draw(st.sampled_from([0.0, 0.5])),
        "device__damping": draw(st.sampled_from([0.0, 0.3])),
        "device__velocity": draw(st.sampled_from(["exact", "euler"])),
    }
    for user in (1, 2):
        values |= {
            f"user{user}__master__rate_drop": draw(st.sampled_from([1, 4, 8])),
            f"user{user}__link__up__delay_s": draw(st.sampled_from([0.0, 0.003, 0.011])),
            f"user{user}__link__down__delay_s": draw(st.sampled_from([0.0, 0.005, 0.016])),
        }
    if draw(st.booleans()):
        values["user2__server__impedance"] = draw(st.floats(5.0, 60.0, exclude_min=True))
    try:
        scenario = linear_loops.scenario(**values)
        linear_model.Loop(scenario)
    except (ParameterError, NonlinearError):  # parameters that do not go together
        assume(False)
    return scenario, draw(st.booleans())


def power_sums(matrix, count=12):
    """trace(A^k), k = 1, 2, ...: the spectrum without zeros, and not how it is written."""
    power, found = np.eye(len(matrix)), []
    for _ in range(count):
        power = power @ matrix
        found.append(np.trace(power))
    return np.array(found)


@settings(max_examples=100)
@given(scenarios())
def test_both_models_have_the_same_spectrum_and_rigid_motions(drawn):
    scenario, live = drawn
    theirs = linear_model.transitions(scenario, live=live)
    ours = linearize(scenario, live=live)
    (b, *_), (motions, *_) = ours.quotient
    # Motions that the other model does not look for leave eigenvalues of one in it.
    others = motions - linear_model.rigid.count(theirs.rigid)
    assert others >= 0
    a = linear_model.rigid.quotient(theirs.matrices, theirs.rigid)[0]
    size = max(1.0, np.abs(np.linalg.eigvals(a)).max(initial=0.0)) ** np.arange(1, 13) * len(a)
    np.testing.assert_array_less(np.abs(power_sums(a) - others - power_sums(b)), 1e-9 * size)


@settings(max_examples=20)
@given(scenarios())
def test_equal_users_make_smaller_models_of_the_same_spectrum(drawn):
    scenario, live = drawn
    both = tuple(dataclasses.replace(scenario.users[0], name=user.name) for user in scenario.users)
    scenario = dataclasses.replace(scenario, users=both)
    whole = power_sums(linearize(scenario, live=live).quotient[0][0])
    smaller = [
        linearize(*part.runs, live=live, weights=part.weights) for part in subproblems(scenario)
    ]
    sums = sum(power_sums(model.quotient[0][0]) for model in smaller)
    np.testing.assert_array_less(np.abs(whole - sums), 1e-8 * (1.0 + np.abs(whole)))


def test_models_side_by_side_are_those_one_by_one():
    runs = [linear_loops.scenario(server__contact_stiffness=k) for k in (0.0, 300.0, 3000.0)]
    together = linearize(*runs)
    for rows, run in zip(together.rows, runs, strict=True):
        sums = [power_sums(matrix) for matrix in (rows, linearize(run).matrices[0])]
        np.testing.assert_allclose(*sums, rtol=1e-12)


@pytest.mark.parametrize(
    "values",
    [
        {"server__coupling": "implicit"},
        {"server__coupling": "one_step_delay", "server__impedance": 20.0},
        {"server__coupling": "unwrapped", "link__delay_s": 0.5},
        {"master__position__feedback": "printed", "master__position__gain": 2.0},
        {"master__bank__kind": "complementary", "device__damping": 0.0},
    ],
)
def test_axes_that_a_matrix_couples_are_those_of_its_eigenvalues(values):
    """A contact, a device and a cube are the same along all axes: so is every principal axis."""
    turn = np.array([[np.cos(0.4), -np.sin(0.4)], [np.sin(0.4), np.cos(0.4)]])
    matrix = turn @ np.diag([30.0, 12.0]) @ turn.T
    text = "; ".join(" ".join(repr(float(value)) for value in row) for row in matrix)
    coupled = linear_loops.scenario(dof=2, master__impedance_matrix=text, **values)
    axes = [linear_loops.scenario(master__impedance=b, **values) for b in (30.0, 12.0)]
    expected = max(float(radii(axis)[0]) for axis in axes)
    assert radii(coupled) == pytest.approx(expected, abs=1e-9)
    if "link__delay_s" not in values:  # else they are opened at their links
        models = [linearize(axis) for axis in axes]
        ours = linearize(coupled)
        assert ours.quotient[1] == sum(model.quotient[1] for model in models)
        sums = sum(power_sums(model.quotient[0][0]) for model in models)
        np.testing.assert_allclose(power_sums(ours.quotient[0][0]), sums, atol=1e-10)
    other = linear_loops.scenario(dof=2, master__impedance_matrix="26 0; 0 10", **values)
    assert radii(other) != pytest.approx(expected, abs=1e-9)


@pytest.fixture
def anew():
    """Return what lifts the law of a tick again: what it calls may be another law meanwhile."""

    def lift():
        elements.lifted.cache_clear()
        kept_loop.cache_clear()
        return elements.lifted(user_tick)

    yield lift
    lift()


def test_what_is_not_linear_is_found_by_superposition_and_named(monkeypatch, anew):
    hold = master.hold

    def rectified(s, ticks):
        s, v = hold(s, ticks)
        return s, tuple(map(abs, v))

    monkeypatch.setattr(master, "hold", rectified)
    send, begin, _, *others = loop.LIFTED
    monkeypatch.setattr(loop, "LIFTED", (send, begin, anew(), *others))
    words = "loop: superposition does not hold for .*user1.port.waves.*use 'pmwvc simulate'"
    with pytest.raises(NonlinearError, match=words):
        linearize(linear_loops.scenario())


def test_the_states_are_those_that_matter_by_name():
    names = linearize(linear_loops.scenario(users=1)).states
    assert names == [
        "user1.port.filter.y",
        "user1.device.x",
        "user1.device.xd",
        "server.environment.ports.0.avatar.contact.springs.deflection",
        "server.environment.body.x",
        "server.environment.body.xd",
    ]
    assert len(Hyperperiod(linear_loops.scenario(users=1)).paths) > len(names)


def test_a_feedback_has_its_reference_before_the_first_tick():
    """Frames, phases and delays by which the first answer heard is to no packet of this end."""
    scenario = linear_loops.scenario(
        master__position__feedback="printed",
        master__position__gain=2.0,
        server__period_s=0.006,
        user1__master__rate_drop=1,
        user2__master__rate_drop=4,
        user2__link__down__delay_s=0.005,
    )
    models = [of(scenario, live=True) for of in (linear_model.transitions, linearize)]
    sums = [power_sums(model.matrices[0]) for model in models]
    np.testing.assert_allclose(*sums, atol=1e-9)
