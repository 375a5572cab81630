# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A question that needs more work than allowed is answered "not known", before the work is done;
what several axes and equal users share is solved once.
"""

import pytest

import pmwvc
from pmwvc_analysis.models import linearize, stability
from pmwvc_analysis.models.answer import answer, sentences
from pmwvc_analysis.models.linearize import build, spectral_radius
from pmwvc_analysis.models.stability import UnknownError

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
