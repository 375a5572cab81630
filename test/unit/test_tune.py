# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The proposal of impedance, filter and hold, against the exact model and closed forms."""

import dataclasses
import functools
import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support import plain as scenarios

from pmwvc_analysis.models import linearize, stability
from pmwvc_analysis.models.linear import relative
from pmwvc_analysis.transparency.transparency import transparency, untouched
from pmwvc_analysis.tune import search
from pmwvc_analysis.tune.criteria import Choice, cost_of, judged, noise_n, rated
from pmwvc_analysis.tune.search import best_impedance, bounds_of
from pmwvc_analysis.tune.words import answer, costs, sentences
from pmwvc_analysis.verdicts.stability import verdict
from pmwvc_core.errors import PmwvcError
from pmwvc_core.params import FilterParams
from pmwvc_core.simulation.session import simulate_one

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


def test_a_choice_that_only_a_contact_damps_is_not_proposed():
    """A matched device under a held force gains a little energy per tick; free, nothing takes
    it where filter and hold pass everything.
    """
    scenario = short("carry_16ms")
    sharp = Choice(22.9, FilterParams(kind="integrate_and_dump"), "zoh")
    row = rated(scenario, sharp, live=False)
    assert row.spectral_radius < 1.0 < row.free_radius
    assert not row.stable and row.cost is None
    best = propose(scenario).best
    assert best.stable and best.free_radius <= 1.0 + 1e-9
    assert "nothing touched" in costs(best, row)


@settings(max_examples=5, deadline=None)
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


def test_more_impedance_is_stiffer_heavier_and_noisier():
    found = propose(wall())
    best, stiffer = found.best, found.others["stiffer"]
    assert stiffer.k_felt > best.k_felt
    assert stiffer.mass_felt > best.mass_felt
    assert stiffer.noise_n > best.noise_n
    assert stiffer.cost > best.cost
    text = costs(best, stiffer)
    assert "stiffness +" in text and "mass +" in text and "noise +50 %" in text


COARSE = ("device.encoder_step_m=5.5e-5", "device.velocity=euler")


def test_noise_counts_where_the_scenario_has_an_encoder():
    exact, coarse = wall(), short("wall", *COARSE)
    best = propose(coarse).best
    assert best.choice.impedance < propose(exact).best.choice.impedance
    assert best.noise_n < 0.6
    loud = dataclasses.replace(best.choice, impedance=90.0)
    assert rated(coarse, loud, live=False).cost > rated(exact, loud, live=False).cost + 10.0


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


@pytest.mark.parametrize(
    ("name", "seed"), [("wall", 0), ("carry_16ms", 1), ("wall_slow", 7), ("three_users", 2)]
)
def test_a_proposal_taken_as_printed_is_stable_and_not_limited_by_safety(name, seed):
    """A random family, every proposal simulated for all of its scenario."""
    rng = np.random.default_rng(seed)
    values = {
        "server.contact_stiffness": float(np.exp(rng.uniform(np.log(200.0), np.log(8000.0)))),
        "link.delay_s": float(rng.choice([0.0, 0.008, 0.03])),
        "device.mass": float(rng.uniform(0.1, 0.5)),
        "device.encoder_step_m": float(rng.choice([0.0, 1e-6, 1e-5, 5.5e-5])),
        "device.velocity": "euler",
    }
    words = [f"{key}={value}" for key, value in values.items()] + ["duration_s=4"]
    scenario = scenarios.load(name, settings_texts=words)
    try:
        best = propose(scenario).best
    except PmwvcError as error:  # a refusal is an answer, and says what to change
        assert "softer" in str(error)
        return
    taken = [f"{key}={value}" for key, value in best.choice.settings(scenario).items()]
    chosen = scenarios.load(name, settings_texts=[*words, *taken])
    assert chosen.users[0].master.filter == best.choice.filter
    assert verdict(simulate_one(chosen), chosen).instability is None


def test_noise_is_that_of_a_rounded_position_differenced():
    scenario = wall(device__encoder_step_m=5e-5)
    step, tick_s, b = 5e-5, scenario.tick_s, 30.0
    rng = np.random.default_rng(3)
    x = np.cumsum(rng.normal(0.02, 0.05, 200_000)) * tick_s
    shown = np.round(x / step) * step
    error = b * (np.diff(shown) - np.diff(x)) / tick_s
    assert np.std(error) == pytest.approx(noise_n(scenario, b), rel=0.02)


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


def test_the_cost_of_the_ideal_is_zero_and_symmetric():
    assert cost_of(1.0, 1.0) == 0.0
    assert cost_of(0.5, 1.0) == pytest.approx(cost_of(2.0, 1.0))
    assert cost_of(1.23, 1.0) == pytest.approx(1.0)
    assert cost_of(1.23, 1.23) == pytest.approx(math.sqrt(2.0))


def test_other_controllers_are_referred_to_their_rules():
    with pytest.raises(PmwvcError, match=r"controller = direct.*docs/controllers\.md"):
        propose(scenarios.load("direct_16ms"))


def test_what_cannot_be_stable_states_what_to_change():
    scenario = wall(
        server__coupling="one_frame_late", server__contact_stiffness=200000, device__mass=0.02
    )
    with pytest.raises(PmwvcError, match=r"no impedance .* softer"):
        propose(scenario)


def test_where_no_impedance_from_the_lag_is_stable_others_are_looked_at():
    fast = {"master__rate_drop": 2, "server__period_s": 0.002, "link__delay_s": 0.03}
    scenario = wall(server__contact_stiffness=738.8, device__mass=0.346, **fast)
    one, bounds = FilterParams(kind="first_order", cutoff_hz=50.0), bounds_of(scenario)
    given = rated(scenario, best_impedance(scenario, one, "zoh", bounds, live=False), live=False)
    assert not given.stable
    found = search.elsewhere(scenario, {"one": one}, [("one", "zoh")], bounds, live=False)
    assert found["one", "zoh"].stable
    lines = sentences(scenario, search.Proposal(found["one", "zoh"], {"given": given}, bounds, []))
    (row,) = [line for line in lines if line.startswith("  given  ")]
    assert row.endswith("NOT stable")


def test_the_settings_printed_give_the_choice():
    found = json.loads(json.dumps(answer(wall(), propose(wall())), allow_nan=False))
    texts = [f"{name}={value}" for name, value in found["best"]["settings"].items()]
    chosen = scenarios.load("wall", settings_texts=texts).users[0].master
    best = propose(wall()).best.choice
    assert chosen.impedance == pytest.approx(best.impedance, abs=0.01)
    assert (chosen.filter, chosen.hold) == (best.filter, best.hold)
    assert set(found) == {"scenario", "not_linear", "bounds", "best", "others", "costs"}
    assert found["not_linear"] == []


def test_on_the_strict_channel_the_impedance_alone_is_chosen():
    scenario = wall(channel="strict", master__hold="zoh")
    found = propose(scenario)
    assert set(found.others) <= {"as given", "stiffer", "lighter"}
    settings_of = found.best.choice.settings(scenario)
    assert list(settings_of) == ["master.impedance"]
    chosen = found.best.choice.applied(scenario).users[0].master
    assert (chosen.filter, chosen.hold) == (scenario.users[0].master.filter, "zoh")
    assert found.best.simulated == "stable" and found.best.aliasing_gain is None
    lines = sentences(scenario, found)
    assert any("the impedance alone is chosen" in line for line in lines)
    assert lines[-1] == f"use it with: --set master.impedance={settings_of['master.impedance']}"
    json.dumps(answer(scenario, found), allow_nan=False)


def test_the_table_names_every_row_and_ends_with_the_command():
    scenario = wall()
    found = propose(scenario)
    lines = sentences(scenario, found)
    assert lines[-1].startswith("use it with: --set master.impedance=")
    for label in found.others:
        assert any(line.strip().startswith(label) for line in lines)
    document = answer(scenario, found)
    assert document["best"]["cost"] == pytest.approx(
        rated(scenario, found.best.choice, live=False).cost
    )
    assert found.best.stable is document["best"]["stable"] is True


@pytest.mark.parametrize(
    ("name", "said", "instead"),
    [
        ("wall_slow", "server.decoding = secant", "server.environment=wall_with_slope"),
        ("active_wall", "server.environment = active_wall", "server.environment=wall_with_slope"),
    ],
)
def test_what_is_not_linear_gets_the_proposal_of_its_relative_and_reports_it(name, said, instead):
    scenario = short(name)
    found = propose(scenario)
    line = sentences(scenario, found)[1]
    assert line.startswith("  not linear: ") and said in line and instead in line
    assert answer(scenario, found)["not_linear"]
    near = propose(relative(scenario).scenario)
    assert near.elements == []
    assert found.best.choice == near.best.choice
    assert found.best.k_felt == near.best.k_felt


def test_noise_and_passivity_are_those_of_the_scenario_not_of_its_relative():
    filtered = short("wall_filtered")
    row = propose(filtered).best
    assert row.choice.impedance < propose(relative(filtered).scenario).best.choice.impedance
    step = filtered.users[0].device.encoder_step_m
    assert row.noise_n == pytest.approx(row.choice.impedance * step / (math.sqrt(6.0) * 1e-3))
    slow = scenarios.load("wall_slow", settings_texts=["server.contact_stiffness=2000"])
    sharp = Choice(25.0, slow.users[0].master.filter, "foh")  # K T_VE > b
    assert rated(slow, sharp, live=False).passive
    words = ["server.coupling=one_step_delay", "server.integrator=backward_euler"]
    late = scenarios.load("wall_slow", settings_texts=["server.contact_stiffness=2000", *words])
    assert not rated(late, sharp, live=False).passive


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
    assert found.elements == []


def test_an_ideal_that_is_not_stable_gives_way_to_the_contact_itself():
    found = propose(short("wall_slow"))
    assert found.best.k_ideal == 500.0
    assert found.best.cost > 0.0
    assert found.best.cost < found.others["as given"].cost
