# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The tuning rules of controllers without waves, held against simulated sessions."""

import dataclasses

import numpy as np
import pytest
from support.plain import load

from pmwvc_analysis.prediction.text import lines
from pmwvc_analysis.verdicts.stability import verdict
from pmwvc_core.controllers import record as tuning
from pmwvc_core.controllers.library import LIBRARY
from pmwvc_core.controllers.record import Loop, loop_of
from pmwvc_core.network.delay_trace import load_delay_trace
from pmwvc_core.params import BaselineParams
from pmwvc_core.params.server import PspmParams, TdpaParams, VirtualCouplingParams
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.simulation.session import simulate_one

PRESS = {
    "name": "press",
    "duration_s": 2.0,
    "controller": "virtual_coupling",
    "users": 2,
    "operator": {"kind": "constant", "force": 1.0},
    "server": {
        "contact": "bilateral",
        "contact_stiffness": 20000.0,
        "contact_damping": 0.0,
        "object_mass": 1.0,
    },
    "task": {"kind": "free"},
    "safety": {"max_force": 20.0},
}
RULES = {name: one.rule for name, one in LIBRARY.items() if one.rule is not None}
LOOP = Loop(
    mass=0.25,
    damping=8.0,
    tick_s=0.001,
    round_trip_s=0.048,
    contact_stiffness=500.0,
    contact_damping=10.0,
    period_s=0.008,
)


def press(delay_s, damping, **overrides):
    values = {"link.delay_s": delay_s, "device.damping": damping}
    values |= {name.replace("__", "."): value for name, value in overrides.items()}
    return parse_scenario(PRESS, overrides=values)


def loop_in(scenario):
    return loop_of(scenario.users[0], scenario.server)


@pytest.mark.parametrize(
    ("delay_s", "damping"), [(0.0, 2.0), (0.016, 2.0), (0.016, 8.0), (0.04, 8.0)]
)
def test_a_virtual_coupling_is_stable_up_to_its_rule_and_not_far_beyond(delay_s, damping):
    loop, own = loop_in(press(delay_s, damping)), 0.5 * damping
    edge = min(2.0 * (damping - own) / loop.tick_s, 2.0 * (damping + own) / loop.round_trip_s)
    at_edge = tuning.check_virtual_coupling(VirtualCouplingParams(edge, own), loop)
    assert min(at_edge.values()) == pytest.approx(0.0, abs=1e-9)
    scenarios = [
        press(
            delay_s,
            damping,
            baseline__virtual_coupling__stiffness=stiffness,
            baseline__virtual_coupling__damping=own,
        )
        for stiffness in (edge, 4.0 * edge)
    ]
    found = [verdict(simulate_one(scenario), scenario).instability for scenario in scenarios]
    assert found == [None, "diverged"]


def test_the_criteria_are_those_published():
    coupling = tuning.check_virtual_coupling(VirtualCouplingParams(400.0, 3.0), LOOP)
    assert coupling == pytest.approx({"colgate": 4.8, "delay": 11.0 - 9.6})
    assert tuning.check_pspm(PspmParams(stiffness=6000.0, damping=2.0), LOOP) == (
        pytest.approx({"sampling": -1.0})
    )
    observed = tuning.check_tdpa(TdpaParams(damping=0.0, damping_max=20.0), LOOP)
    assert observed == pytest.approx({"sampling": 5.0, "delay": 8.0 - 12.0, "contact": 8.0})
    assert min(observed.values()) < 0.0


@pytest.mark.parametrize(
    ("name", "dampings"), [("carry_16ms", (0.0, 3.0)), ("carry_24ms", (3.0, 8.1))]
)
def test_time_domain_passivity_oscillates_without_the_local_damping_of_its_rule(name, dampings):
    """3 N s/m are enough at 16 ms and too little at 24 ms; the rule asks for 4.1 and 8.1."""
    words = ["controller=tdpa", "duration_s=9"]
    ours = -tuning.check_tdpa(TdpaParams(damping=0.0), loop_in(load(name)))["delay"]
    assert ours == pytest.approx(4.1 if name == "carry_16ms" else 8.1)
    scenarios = [
        load(name, settings_texts=[*words, f"baseline.tdpa.damping={damping}"])
        for damping in dampings
    ]
    found = [verdict(simulate_one(scenario), scenario).stable for scenario in scenarios]
    assert found == [False, True]


def test_a_damper_within_its_rule_does_not_chatter_on_an_encoder():
    """The control is half of what stops the device: 10 um steps then drive it."""
    words = ["controller=tdpa", "duration_s=4", "device.encoder_step_m=1e-5"]
    words.append("device.velocity=euler")
    scenarios = [
        load("carry_16ms", settings_texts=[*words, f"baseline.tdpa.damping_max={most}"])
        for most in (25.0, 125.0)
    ]
    within, beyond = map(_true_balance, map(simulate_one, scenarios))
    assert within > -2.5e-3 > beyond


def _true_balance(traces):
    """Lowest energy [J] of the first user's link: work of the held force over its way, less what
    came out at the avatar.
    """
    user, server = traces.users[0], traces.server
    work = np.cumsum(user.f_applied[:-1, 0] * np.diff(user.x_m[:, 0]))
    out = server.period_s * np.cumsum(server.f_s[0][:, 0] * server.xd_s[0][:, 0])
    steps = np.searchsorted(server.time_s, user.time_s[1:] - 1e-6, side="right") - 1
    return float((work - out[steps]).min())


@pytest.mark.parametrize(("stiffness", "diverges"), [(2000.0, False), (4000.0, True)])
def test_a_contact_too_stiff_for_the_servers_step_stays_unstable_on_any_link(stiffness, diverges):
    """B = 10 N s/m at 8 ms allows 2,500 N/m."""
    scenario = load(
        "carry_24ms",
        settings_texts=[
            "controller=tdpa",
            "duration_s=9",
            f"server.contact_stiffness={stiffness}",
        ],
    )
    criteria = LIBRARY["tdpa"].check(BaselineParams(), loop_in(scenario))
    assert (criteria["contact"] < 0.0) is diverges
    assert (verdict(simulate_one(scenario), scenario).instability == "diverged") is diverges


def test_a_hand_damps_and_packets_age_by_their_periods():
    held = press(0.016, 1.0, operator__kind="hand", link__jitter="uniform", link__jitter_s=0.002)
    loop = loop_in(held)
    assert loop.damping == pytest.approx(1.0 + 7.9)
    assert loop.round_trip_s == pytest.approx(2 * (0.016 + 0.002) + 0.008 + 0.008)
    assert loop_in(press(0.016, 1.0)).damping == 1.0


def recorded(tmp_path, **overrides):
    """A press over links whose delay follows a recording: 10 ms, once 70 ms."""
    path = tmp_path / "delays.txt"
    path.write_text("time delay\n0 10\n0.1 70\n0.2 10\n0.3 10\n")
    trace = {"link__trace_file": str(path), "link__trace_scale": 0.001}
    return press(0.0, 8.0, link__jitter="trace", **trace, **overrides)


def test_a_recorded_delay_counts_with_its_longest(tmp_path):
    scenario = recorded(tmp_path, baseline__virtual_coupling__stiffness=400)
    assert loop_in(scenario).round_trip_s == pytest.approx(2 * 0.07 + 0.008 + 0.008)
    assert "user1: rule 'delay' NOT met, deficit 20.2 N s/m." in lines(scenario, live=False)


@pytest.mark.parametrize("controller", [name for name in RULES if name != "pspm"])
def test_a_rule_is_unknown_where_a_delay_is(tmp_path, controller):
    lost = recorded(tmp_path)
    (tmp_path / "delays.txt").unlink()
    load_delay_trace.cache_clear()
    slow = press(0.016, 8.0, link__down__rate_limit_bps=1e6)
    for scenario, effect in ((lost, "trace"), (slow, "rate_limit")):
        found = lines(dataclasses.replace(scenario, controller=controller), live=False)
        assert any(f"rule 'delay' unknown: the longest delay by {effect}" in one for one in found)
        checked = LIBRARY[controller].check(BaselineParams(), loop_in(scenario))
        assert not all(margin >= 0.0 for margin in checked.values())


@pytest.mark.parametrize("controller", RULES)
def test_the_defaults_meet_their_rules_at_24_ms_with_the_default_hand(controller):
    values = {"link.delay_s": 0.024, "server.contact_stiffness": 500.0}
    values |= {"server.contact_damping": 10.0, "operator.kind": "hand"}
    loop = loop_in(parse_scenario(PRESS, overrides=values))
    assert min(LIBRARY[controller].check(BaselineParams(), loop).values()) >= 0.0


def test_before_a_session_the_rules_are_reported_with_their_margins():
    kept, broken = (press(0.016, 8.0, baseline__virtual_coupling__stiffness=k) for k in (400, 600))
    assert "user1: rule 'delay' met, margin 1.4 N s/m." in lines(kept, live=False)
    assert "user2: rule 'delay' NOT met, deficit 3.4 N s/m." in lines(broken, live=False)
