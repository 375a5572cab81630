# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A question that needs more work than allowed is answered "not known", before the work is done;
what several axes and equal users share is solved once.
"""

import numpy as np
import pytest
from support import linear_loops

import pmwvc
from pmwvc_analysis.models import linearize, stability
from pmwvc_analysis.models.answer import answer, sentences
from pmwvc_analysis.models.linear import axes_of
from pmwvc_analysis.models.linearize import build, spectral_radius
from pmwvc_analysis.models.stability import UnknownError
from pmwvc_analysis.models.variation import subproblems

SEVEN_AND_ELEVEN = {"master.rate_drop": 7, "server.period_s": 0.011}


def test_unequal_frames_over_a_long_way_have_the_radius_of_the_whole_model():
    scenario = pmwvc.scenario("carry_16ms", {**SEVEN_AND_ELEVEN, "link.delay_s": 0.25})
    assert scenario.users[0].master.frame_s != scenario.server.period_s
    found = float(stability.radii(scenario)[0])
    assert linearize.stable(found)
    assert found == pytest.approx(spectral_radius(build(scenario)), rel=1e-7)


def test_a_largest_stiffness_that_takes_too_much_is_not_known_beside_a_radius_that_is(monkeypatch):
    monkeypatch.setattr(stability, "ALLOWED", 1e9)  # enough for one radius, not for a search
    scenario = pmwvc.scenario("carry_16ms", {**SEVEN_AND_ELEVEN, "link.delay_s": 0.25})
    found = answer(scenario)
    assert found["stable"] is True
    assert found["k_max"] is None and "not known" in found["k_max_unknown"]
    text = "\n".join(sentences(found))
    assert "largest stable contact stiffness: carry_16ms: not known" in text
    assert "stable at every contact stiffness" not in text


def test_a_hyperperiod_of_thousands_of_ticks_is_refused_with_its_length_and_a_way_out():
    scenario = pmwvc.scenario("carry_16ms", {"master.rate_drop": 97, "server.period_s": 0.101})
    with pytest.raises(UnknownError, match=r"not known: a hyperperiod of 9797 ticks.*simulate"):
        stability.radii(scenario)
    assert "not known" in stability.k_max(scenario).unknown


def test_what_is_known_says_nothing_of_work():
    found = answer(pmwvc.scenario("carry_16ms"))
    assert found["k_max_unknown"] == ""


def matrix_of(values, turn):
    """Return the text of a matrix with these eigenvalues and axes turned by an angle [rad]."""
    c, s = np.cos(turn), np.sin(turn)
    axes = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    matrix = (axes * np.asarray(values)) @ axes.T
    matrix = 0.5 * (matrix + matrix.T)
    return "; ".join(" ".join(repr(float(value)) for value in row) for row in matrix)


@pytest.mark.parametrize("seed", range(6))
def test_axes_that_all_ends_share_are_problems_of_one_axis_with_the_same_radius(seed):
    rng = np.random.default_rng(seed)
    turn = rng.uniform(0.2, 1.2)
    scenario = linear_loops.scenario(
        dof=3,
        channel="plain",
        master__impedance_matrix=matrix_of(rng.uniform(10.0, 40.0, 3), turn),
        server__impedance_matrix=matrix_of(rng.uniform(10.0, 40.0, 3), turn),
    )
    parts = subproblems(scenario)
    assert all(axes_of(part.runs[0]) == 1 for part in parts)
    whole = spectral_radius(build(scenario))
    assert stability.radii(scenario)[0] == pytest.approx(whole, rel=1e-9)


def test_equal_axes_are_one_problem():
    one = linear_loops.scenario(dof=3, master__impedance=20.0)
    three = linear_loops.scenario(dof=3, master__impedance_matrix="20 0 0; 0 20 0; 0 0 20")
    assert len(subproblems(three)) == len(subproblems(one))
    assert stability.radii(three)[0] == pytest.approx(stability.radii(one)[0], rel=1e-12)


def test_axes_that_differ_between_the_ends_stay_together():
    scenario = linear_loops.scenario(
        dof=3,
        channel="plain",
        master__impedance_matrix=matrix_of((10.0, 20.0, 40.0), 0.3),
        server__impedance_matrix=matrix_of((10.0, 20.0, 40.0), 0.9),
    )
    assert all(axes_of(part.runs[0]) == 3 for part in subproblems(scenario))
    whole = spectral_radius(build(scenario))
    assert stability.radii(scenario)[0] == pytest.approx(whole, rel=1e-9)
