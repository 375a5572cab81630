# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Stability of the exact model against printed and checked numbers, and against a second route:
the largest stiffness of two users on one cube (App. B, Figs. 2 and 3) for each coupling. The
figures of the dissertation show the regions of ``one_frame_late`` when its cut-off is read as the
pole in rad/s; two other readings of it follow.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracle import linear_model
from oracle.linear_model import couplings
from support import linear_loops

from pmwvc_analysis.models.linearize import build, linearize, spectral_radius
from pmwvc_analysis.models.stability import k_max, radii, z_width
from pmwvc_analysis.models.variation import with_stiffness
from pmwvc_core.scenario.names import varied

FRAME_S = 0.008
LATE = {"server__coupling": "one_frame_late"}
# Largest symmetric stiffness [N/m] of two users, App. B, for 0 to 3 frames of delay each way.
LARGEST = [
    (LATE, 50.0, (5280.5, 2470.8, 2166.0, 2224.2)),
    (LATE, 100.0, (1037.4, 988.2, 965.4, 952.2)),
    (LATE | {"master__hold": "foh"}, 50.0, (4528.2, 2433.9, 2164.5, 2181.7)),
    (LATE | {"master__hold": "foh"}, 100.0, (973.2, 943.0, 928.3, 919.8)),
    (
        {"server__coupling": "one_step_delay", "server__integrator": "forward_euler"},
        50.0,
        (2950.1, 3084.7, 2604.5, 2674.5),
    ),
    (
        {"server__coupling": "one_step_delay", "server__integrator": "backward_euler"},
        50.0,
        (8482.3, 3595.2, 2774.5, 2488.5),
    ),
    ({"controller": "direct"}, 50.0, (2500.0, 335.3, 47.1, 0.0)),
    (LATE, 2 * np.pi * 50 / np.sqrt(99), (4850.0, 2854.0, 2810.0, 3093.0)),  # -20 dB at 50 Hz
    (LATE, 2 * np.pi * 50, (0.0,)),  # -3 dB at 50 Hz
]


@pytest.mark.parametrize(("values", "pole", "largest"), LARGEST)
def test_the_largest_stiffness_of_app_b(values, pole, largest):
    for frames, expected in enumerate(largest):
        scenario = linear_loops.scenario(
            master__filter__pole_rad_s=pole, link__delay_s=frames * FRAME_S, **values
        )
        assert k_max(scenario).first == pytest.approx(expected, rel=5e-3, abs=1e-9)


@pytest.mark.parametrize("hold", ["zoh", "foh"])
@pytest.mark.parametrize("delay_s", [0.0, 0.024, 0.4])
def test_the_implicit_coupling_has_no_largest_stiffness(hold, delay_s):
    scenario = linear_loops.scenario(master__hold=hold, link__delay_s=delay_s)
    assert k_max(scenario, bound=1e7).first is None


AROUND = (
    {},
    {"velocity_filter__kind": "exact", "velocity_filter__cutoff_hz": 15.0},
    {"velocity_filter__kind": "equivalent", "velocity_filter__cutoff_hz": 90.0},
    {"velocity_filter__kind": "complementary", "velocity_filter__cutoff_hz": 40.0},
    {"bank__kind": "dissertation", "local_model__damping": 4.0},
    {"bank__kind": "complementary", "local_model__stiffness": 900.0},
)


@st.composite
def scenarios(draw):
    users = draw(st.integers(3, 5))
    m = draw(st.sampled_from([1, 2, 5, 8, 13, 20, 32]))
    values = {
        "users": users,
        "master__rate_drop": m,
        "server__period_s": m * 1e-3,
        "master__hold": draw(st.sampled_from(["zoh", "foh"])),
        "server__coupling": draw(
            st.sampled_from(["implicit", "one_step_delay", "one_frame_late", "unwrapped"])
        ),
        "server__integrator": draw(
            st.sampled_from(["forward_euler", "backward_euler", "trapezoid"])
        ),
        "server__object_mass": draw(st.floats(0.5, 4.0)),
        "server__object_damping": draw(st.sampled_from([0.0, 1.0])),
        "master__filter__pole_rad_s": draw(st.floats(20.0, 120.0)),
    }
    around = draw(st.sampled_from(AROUND))
    values |= {f"master__{name}": value for name, value in around.items()}
    for user in range(1, users + 1):
        values[f"user{user}__master__impedance"] = draw(st.floats(8.0, 50.0))
        values[f"user{user}__device__mass"] = draw(st.floats(0.1, 0.6))
        values[f"user{user}__server__contact_stiffness"] = draw(st.floats(50.0, 2000.0))
        values[f"user{user}__server__contact_damping"] = draw(st.floats(1.0, 12.0))
        for way in ("up", "down"):
            frames = draw(st.integers(0, 3))
            values[f"user{user}__link__{way}__delay_s"] = frames * m * 1e-3
    return linear_loops.scenario(**values)


def radius_by_hand(scenario):
    """Return the spectral radius of the model written out by hand, rigid motions taken out."""
    found = linear_model.transitions(scenario)
    a = linear_model.rigid.quotient(found.matrices, found.rigid)[0]
    return np.abs(np.linalg.eigvals(a)).max()


@settings(max_examples=20)
@given(scenarios())
def test_the_spectral_radius_agrees_with_the_model_written_by_hand(scenario):
    found = spectral_radius(build(scenario))
    assert found == pytest.approx(radius_by_hand(scenario), rel=1e-6)


def test_a_model_with_another_delay_does_not_agree():
    late = linear_loops.scenario(user1__link__up__delay_s=0.008, server__coupling="unwrapped")
    later = linear_loops.scenario(user2__link__up__delay_s=0.016, server__coupling="unwrapped")
    expected = radius_by_hand(late)
    assert spectral_radius(build(late)) == pytest.approx(expected, rel=1e-9)
    assert spectral_radius(build(later)) != pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize(("frames", "expected"), [(0, 139), (1, 103), (2, 83), (3, 70)])
def test_equation_14_as_published_is_far_from_its_own_figure(frames, expected, monkeypatch):
    """The control: with the sign it has in print the largest stiffness is that of no figure."""
    corrected = couplings.LAWS["one_frame_late"]

    def printed(seats, body, params):
        corrected(seats, body, params)
        for seat in seats:
            seat.rows["xd_s"] = seat.rows["xd_s"] + 2.0 * seat.rows["f"] / seat.b

    monkeypatch.setitem(couplings.LAWS, "one_frame_late", printed)
    scenario = linear_loops.scenario(link__delay_s=frames * FRAME_S, **LATE)
    below, above = (with_stiffness(scenario, k * expected) for k in (0.99, 1.01))
    assert radius_by_hand(below) <= 1.0 + 1e-9 < radius_by_hand(above)


@pytest.mark.parametrize("controller", ["pmwvc", "direct", "virtual_coupling"])
@pytest.mark.parametrize("coupling", ["implicit", "one_step_delay", "one_frame_late", "unwrapped"])
@pytest.mark.parametrize("live", [False, True])
def test_equal_users_are_taken_together_without_a_difference(controller, coupling, live):
    for values in (
        {"users": 5, "user2__device__mass": 0.4, "user4__device__mass": 0.4},
        {"users": 3, "server__environment": "wall"},
        {"users": 4, "user3__master__rate_drop": 4, "user4__master__rate_drop": 4},
        {"users": 2, "server__contact_stiffness": 0.0},
        {"users": 3, "user3__master__rate_drop": 12},
    ):
        scenario = linear_loops.scenario(
            controller=controller,
            server__coupling=coupling,
            link__delay_s=0.008,
            **{"server__contact_stiffness": 700.0} | values,
        )
        expected = linearize(scenario, live=live).radii()[0]
        assert radii(scenario, live=live)[0] == pytest.approx(expected, rel=1e-9)


def test_a_batch_equals_one_by_one():
    scenario = linear_loops.scenario(link__delay_s=0.016, server__coupling="one_frame_late")
    values = 0.0, 50.0, 700.0, 2500.0, 9000.0
    together = radii(*(with_stiffness(scenario, k) for k in values))
    alone = [radii(with_stiffness(scenario, float(k)))[0] for k in values]
    np.testing.assert_allclose(together, alone, rtol=1e-9)


STACKED = [
    ("master.velocity_filter.share", (0.1, 0.5, 0.9), {"master__velocity_filter__kind": "exact"}),
    (
        "master.velocity_filter.cutoff_hz",
        (20.0, 60.0),
        {"master__velocity_filter__kind": "complementary"},
    ),
    ("master.bank.split_rad_s", (20.0, 90.0), {"master__bank__kind": "complementary"}),
    ("master.local_model.stiffness", (0.0, 100.0, 2e3), {"master__bank__kind": "dissertation"}),
    ("master.position.gain", (0.0, 5.0, 30.0), {"master__position__feedback": "printed"}),
    (
        "baseline.virtual_coupling.stiffness",
        (50.0, 900.0),
        {"controller": "virtual_coupling"},
    ),
    (
        "server.contact_damping",
        (0.0, 9.0),
        {
            "server__coupling": "unknown",
            "server__compensation": "none",
            "server__decoding": "late",
        },
    ),
]


@pytest.mark.parametrize(("name", "values", "others"), STACKED)
def test_parameters_around_the_port_stack(name, values, others):
    scenario = linear_loops.scenario(link__delay_s=0.016, **others)
    together = radii(*(varied(scenario, name, value) for value in values))
    alone = [radii(varied(scenario, name, value))[0] for value in values]
    np.testing.assert_allclose(together, alone, rtol=1e-9)
    assert np.ptp(alone) > 1e-9


ISLANDS = [
    ({"server__coupling": "one_step_delay", "server__contact_damping": 0.0}, 0.024),
    ({"server__coupling": "one_frame_late", "server__contact_damping": 20.0}, 0.008),
]


@pytest.mark.parametrize(("values", "delay_s"), ISLANDS)
def test_islands_above_the_first_crossing_are_found(values, delay_s):
    scenario = linear_loops.scenario(link__delay_s=delay_s, **values)
    limit = k_max(scenario)
    assert len(limit.islands) == 1
    edges = [limit.first, *limit.islands[0]]
    for edge, (below, above) in zip(
        edges, [(True, False), (False, True), (True, False)], strict=True
    ):
        for factor, stable in ((0.999, below), (1.001, above)):
            if edge > 0.0:
                radius = radii(with_stiffness(scenario, edge * factor))[0]
                assert bool(radius <= 1.0) is stable


def test_the_z_width_narrows_with_damping_where_the_computation_is_late():
    late = {"server__coupling": "one_step_delay", "server__environment": "wall", "users": 1}
    damping = [0.0, 10.0, 20.0, 30.0]
    limits = z_width(linear_loops.scenario(**late), damping)
    firsts = [limit.first for limit in limits]
    assert firsts == sorted(firsts, reverse=True)
    for b, limit in zip(damping, limits, strict=True):
        for factor, stable in ((0.999, True), (1.001, False)):
            scenario = linear_loops.scenario(
                server__contact_damping=b, server__contact_stiffness=limit.first * factor, **late
            )
            assert bool(radii(scenario)[0] <= 1.0) is stable
    at_once = linear_loops.scenario(**late | {"server__coupling": "implicit"})
    assert [limit.first for limit in z_width(at_once, damping)] == [None] * 4
