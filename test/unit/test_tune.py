# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The proposal of impedance, filter and hold, against the exact model and closed forms."""

import functools
import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support import plain as scenarios

from pmwvc_analysis.models import linearize, stability
from pmwvc_analysis.transparency.transparency import transparency, untouched
from pmwvc_analysis.tune import search
from pmwvc_analysis.tune.criteria import Choice, cost_of, judged, rated
from pmwvc_analysis.tune.search import best_impedance, bounds_of, two_impedances
from pmwvc_analysis.tune.words import answer, sentences
from pmwvc_core.errors import PmwvcError
from pmwvc_core.params import FilterParams

propose = functools.cache(search.propose)  # of a scenario: once


SHORT = "duration_s=2"  # a touch and a press: what a proposal is simulated for


def short(name, *texts):
    """Return a scenario whose proposals are simulated for a short time."""
    return scenarios.load(name, settings_texts=[SHORT, *texts])


def wall(**settings_by_name):
    texts = [f"{name.replace('__', '.')}={value}" for name, value in settings_by_name.items()]
    return short("wall", *texts)


def test_the_proposal_is_stable_in_touch_and_free_and_passive_part_by_part():
    found = propose(wall())
    chosen = found.best.choice.applied(wall())
    assert found.best.passive
    assert linearize.stable(float(stability.radii(chosen)[0]))
    assert linearize.stable(float(stability.radii(untouched(chosen))[0]))


@settings(max_examples=3, deadline=None)
@given(
    delay_s=st.sampled_from([0.0, 0.004, 0.016, 0.04]),
    stiffness=st.floats(100.0, 3000.0),
    hold=st.sampled_from(["zoh", "foh"]),
)
def test_the_impedance_from_the_lag_is_nearly_the_best_of_the_exact_model(
    delay_s, stiffness, hold
):
    scenario = wall(
        link__delay_s=delay_s,
        server__contact_stiffness=stiffness,
        master__filter__kind="first_order",
    )
    one, arm = scenario.users[0].master.filter, scenario.users[0].operator.mass
    low, high = bounds_of(scenario)

    def exact(impedance):
        chosen = Choice(impedance, one, hold).applied(scenario)
        found = transparency(chosen, np.array([1.0]))
        weight = (found.rendered.mass_felt + arm) / (found.ideal.mass_felt + arm)
        return cost_of(found.rendered.k_felt / found.ideal.k_felt, weight)

    ours = exact(best_impedance(scenario, one, hold, (low, high), live=False).impedance)
    best = min(exact(float(b)) for b in np.geomspace(max(low, 8.0), min(high, 80.0), 9))
    assert ours <= best + 0.15  # of a just noticeable step


COARSE = ("device.encoder_step_m=5.5e-5", "device.velocity=euler")


def test_what_the_model_calls_best_and_the_limits_stop_is_not_proposed():
    """The control: the stiffest link in the model, at which one step of the encoder is 5 N."""
    scenario = short("wall", *COARSE, "server.contact_stiffness=8000")
    integrate = FilterParams(kind="integrate_and_dump")
    loud = Choice(91.19, integrate, "zoh")
    row = rated(scenario, loud, live=False)
    assert row.stable
    assert judged(scenario, row).simulated == "limited by safety"
    best = propose(scenario).best
    assert best.simulated == "stable" and best.choice.impedance < 20.0
    assert "simulated for 2 s" in "".join(sentences(scenario, propose(scenario)))


def test_a_delayed_port_gets_an_impedance_that_keeps_it_passive():
    scenario = wall(
        server__coupling="one_step_delay",
        server__contact_damping=15,
        server__contact_stiffness=1000,
    )
    contact, server = scenario.users[0].contact, scenario.server
    needed = contact.contact_stiffness * server.period_s + 2.0 * contact.contact_damping
    best = propose(scenario).best
    assert best.passive and best.choice.impedance == pytest.approx(needed)
    below = Choice(0.5 * needed, best.choice.filter, best.choice.hold)
    assert not rated(scenario, below, live=False).passive


def test_other_controllers_are_referred_to_their_rules():
    with pytest.raises(PmwvcError, match=r"controller = direct.*docs/controllers\.md"):
        propose(scenarios.load("direct_16ms"))


def test_what_cannot_be_stable_states_what_to_change():
    scenario = wall(
        server__coupling="one_frame_late", server__contact_stiffness=200000, device__mass=0.02
    )
    with pytest.raises(PmwvcError, match=r"no impedance .* softer"):
        propose(scenario)


def test_the_settings_printed_give_the_choice():
    found = json.loads(json.dumps(answer(wall(), propose(wall())), allow_nan=False))
    texts = [f"{name}={value}" for name, value in found["best"]["settings"].items()]
    chosen = scenarios.load("wall", settings_texts=texts).users[0].master
    best = propose(wall()).best.choice
    assert chosen.impedance == pytest.approx(best.impedance, abs=0.01)
    assert (chosen.filter, chosen.hold) == (best.filter, best.hold)
    assert set(found) == {"scenario", "not_linear", "bounds", "best", "others"}
    assert found["not_linear"] == []


def test_on_the_strict_channel_impedances_alone_are_chosen():
    scenario = wall(channel="strict", master__hold="zoh")
    found = propose(scenario)
    assert set(found.others) <= {"as given", "stiffer", "lighter", "one b"}
    settings_of = found.best.choice.settings(scenario)
    assert list(settings_of) == ["master.impedance", "master.contact_impedance"]
    chosen = found.best.choice.applied(scenario).users[0].master
    assert (chosen.filter, chosen.hold) == (scenario.users[0].master.filter, "zoh")
    assert found.best.simulated == "stable" and found.best.aliasing_gain is None
    lines = sentences(scenario, found)
    assert any("impedances alone are chosen" in line for line in lines)
    texts = [f"--set {name}={value}" for name, value in settings_of.items()]
    assert lines[-1] == f"use it with: {' '.join(texts)}"
    json.dumps(answer(scenario, found), allow_nan=False)


@pytest.mark.parametrize(
    ("name", "delay_s", "stiffness"),
    [("wall", 0.002, 200.0), ("wall", 0.016, 2000.0), ("carry_16ms", 0.03, 500.0)],
)
def test_two_impedances_press_stiffer_and_move_lighter_than_one(name, delay_s, stiffness):
    """Stiffness and mass by their closed forms, 1/(1/K + tau/2b) and m + b tau/2; the mass of the
    link is at most just noticed beside device and arm.
    """
    texts = [f"link.delay_s={delay_s}", f"server.contact_stiffness={stiffness}", "channel=strict"]
    scenario = short(name, *texts)
    user, bounds = scenario.users[0], bounds_of(scenario)
    same = best_impedance(scenario, user.master.filter, "foh", bounds, live=False)
    both = two_impedances(scenario, same, bounds, live=False)
    one, two = (rated(scenario, choice, live=False) for choice in (same, both))
    b, touching = two.choice.impedance, two.choice.contact
    assert b <= one.choice.impedance <= touching
    assert two.cost <= one.cost + 1e-9 and two.mass_felt <= one.mass_felt + 1e-9
    felt = 1.0 / (1.0 / stiffness + two.lag_s / (2.0 * touching))
    assert two.k_felt == pytest.approx(felt, rel=1e-3)
    link_kg = two.mass_felt - user.device.mass
    assert link_kg == pytest.approx(b * two.lag_s / 2.0, rel=0.05)
    assert link_kg <= 0.25 * (user.device.mass + user.operator.mass)


def test_a_number_is_proposed_for_a_matrix_which_is_rated_as_given():
    scenario = short("cube_3d")
    found = propose(scenario)
    texts = [f"{name}={value}" for name, value in found.best.choice.settings(scenario).items()]
    assert "master.impedance_matrix=" in texts
    taken = scenarios.load("cube_3d", settings_texts=texts)
    assert taken.users[1].impedance == pytest.approx(found.best.choice.impedance, abs=0.01)
    matrix = np.array([[30.0, 6.0, 0.0], [6.0, 20.0, 4.0], [0.0, 4.0, 25.0]])
    along = 1.0 / np.linalg.inv(matrix)[0, 0]
    given = found.others["as given"]
    assert given.choice.impedance == pytest.approx(along)
    assert not any("impedance" in name for name in given.choice.settings(scenario))
    assert given.choice.applied(scenario) is scenario
    assert given.k_felt == transparency(scenario).rendered.k_felt
    assert answer(scenario, found)["not_linear"] == []
