# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The exact model: nonlinear scenarios are refused by name with the nearest linear one;
frequencies of motions are not those of the hyperperiod; more work than allowed is answered "not
known".
"""

import math

import pytest
from support import linear_loops
from support import plain as files

import pmwvc
from pmwvc_analysis.models import linearize, stability
from pmwvc_analysis.models.answer import answer, sentences
from pmwvc_analysis.models.linear import NonlinearError, nonlinear, relative
from pmwvc_analysis.models.linearize import build, spectral_radius
from pmwvc_analysis.models.links import LinkWay, Times
from pmwvc_analysis.models.stability import UnknownError
from pmwvc_analysis.models.variation import settled_pace, with_stiffness
from pmwvc_core.law.channel.pace import NEW, pace_arrive, pace_step

SECANT = {"server__coupling": "unknown", "server__environment": "wall"}
BLACK_BOX = SECANT | {"server__decoding": "late"}
REFUSED = [
    ({"server__compensation": "printed"} | BLACK_BOX, "server.compensation=none"),
    ({"server__compensation": "corrected"} | BLACK_BOX, "server.compensation=none"),
    ({"server__compensation": "ledger"} | BLACK_BOX, "server.compensation=none"),
    (BLACK_BOX | {"server__environment": "hunt_crossley"}, "server.environment=wall"),
    (BLACK_BOX | {"server__environment": "active_wall"}, "server.environment=wall"),
    (SECANT, "server.environment=wall_with_slope"),
    (SECANT | {"server__environment": "cube"}, "server.decoding=late"),
    (SECANT | {"server__environment": "hunt_crossley"}, "server.environment=wall_with_slope"),
    ({"master__position__gain": 10.0}, "master.position.feedback=printed"),
    (
        {"master__position__gain": 10.0, "master__position__feedback": "integral"},
        "master.position.feedback=printed",
    ),
    ({"controller": "pspm"}, "controller=virtual_coupling"),
    ({"device__friction": 0.1}, "device.friction=0"),
    ({"device__encoder_step_m": 1e-5}, "device.encoder_step_m=0"),
    ({"link__up__rate_limit_bps": 1e5}, "link.up.rate_limit_bps=0"),
]


@pytest.mark.parametrize(("values", "instead"), REFUSED)
def test_it_is_refused_by_name_and_has_a_linear_relative(values, instead):
    scenario = linear_loops.scenario(**values)
    with pytest.raises(NonlinearError) as error:
        build(scenario)
    assert f"--set {instead}" in str(error.value)
    for element in nonlinear(scenario):
        assert element.text in str(error.value)
    near = relative(scenario)
    assert instead in near.settings
    assert nonlinear(near.scenario) == []
    assert build(near.scenario).states


def test_dissipation_that_is_counted_has_no_linear_relative():
    scenario = linear_loops.scenario(controller="tdpa")
    assert relative(scenario) is None
    with pytest.raises(NonlinearError, match="controller = tdpa: has no linear model, and none"):
        build(scenario)


@pytest.mark.parametrize("name", files.known())
def test_every_scenario_is_linear_or_has_a_linear_relative(name):
    scenario = files.load(name)
    near = relative(scenario)
    if scenario.environment.linear is None:  # a scene
        assert near is None and nonlinear(scenario)
    else:
        assert nonlinear(near.scenario if near else scenario) == []


SEVEN_AND_ELEVEN = {"master.rate_drop": 7, "server.period_s": 0.011}


def test_unequal_frames_over_a_long_way_have_the_radius_of_the_whole_model():
    settings = {"master.rate_drop": 4, "server.period_s": 0.006, "link.delay_s": 0.1}
    scenario = pmwvc.scenario("carry_16ms", settings)
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
    text = "\n".join(sentences(scenario, live=False))
    assert "largest stable contact stiffness: carry_16ms: not known" in text
    assert "stable at every contact stiffness" not in text


def test_a_hyperperiod_of_thousands_of_ticks_is_refused_with_its_length_and_a_way_out():
    scenario = pmwvc.scenario("carry_16ms", {"master.rate_drop": 97, "server.period_s": 0.101})
    with pytest.raises(UnknownError, match=r"not known: a hyperperiod of 9797 ticks.*simulate"):
        stability.radii(scenario)
    assert "not known" in stability.k_max(scenario).unknown


def test_stiffnesses_keep_their_proportion():
    scenario = linear_loops.scenario(
        user1__server__contact_stiffness=100.0, user2__server__contact_stiffness=400.0
    )
    found = with_stiffness(scenario, 1000.0)
    assert [user.contact.contact_stiffness for user in found.users] == [250.0, 1000.0]


@pytest.mark.parametrize(
    "way",
    [
        LinkWay(Times(7, 0), Times(11, 0), 2),
        LinkWay(Times(8, 0), Times(8, 0), 3),
        LinkWay(Times(11, 2), Times(1, 0), 5),
        LinkWay(Times(4, 0), Times(8, 3), 1),
    ],
)
def test_a_clock_that_has_settled_repeats_with_the_hyperperiod(way):
    def after_another(pace):
        for look in range(way.looked.phase, math.lcm(way.sent[0], way.looked[0]), way.looked[0]):
            for _ in way.arrivals(look):
                pace = pace_arrive(pace, way.sent.period * 1e-3)
            pace, _, _ = pace_step(pace, way.looked.period * 1e-3)
        return pace

    settled = settled_pace(way, 1e-3)
    assert after_another(settled) == pytest.approx(settled, abs=1e-15)
    assert settled.burst_s == 0.0
    assert after_another(NEW) != pytest.approx(NEW, abs=1e-9)  # the control
