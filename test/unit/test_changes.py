# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters that change during a session in virtual time, and what is judged and
accounted of it.
"""

import dataclasses
from dataclasses import replace

import numpy as np
import pytest
from support import plain as scenarios
from support.handmade import oscillating

from pmwvc_analysis.budget.budget import budget
from pmwvc_analysis.events import events
from pmwvc_analysis.traces.consistency import inconsistencies
from pmwvc_analysis.verdicts.verdicts import summary
from pmwvc_core.errors import ScenarioError
from pmwvc_core.scenario.names import Change, changes_text, over_time, read_changes
from pmwvc_core.simulation.session import SteppedSession, simulate_one

CHANGES = (
    "2.5 server.coupling=one_step_delay; 2.9 server.coupling=implicit; "
    "3.0 server.contact_stiffness=3000; 3.4 server.object_mass=0.8 server.object_damping=4"
)


def carrying(changes, duration_s=4.5, **settings):
    texts = [f"changes={changes}", "task.move_s=2.2", "task.move_rise_s=1.5"]
    texts += [f"{name.replace('__', '.')}={value}" for name, value in settings.items()]
    return scenarios.load("carry_16ms", settings_texts=texts, duration_s=duration_s)


@pytest.fixture(scope="module")
def changed():
    scenario = carrying(CHANGES)
    return simulate_one(scenario), scenario


def worst(found):
    return max(float(np.abs(sums).max()) for sums in found.residuals.values())


def test_the_budget_closes_to_rounding_and_ends_at_the_first_change_of_the_server(changed):
    traces, scenario = changed
    found = budget(traces, scenario)
    assert worst(found) < 1e-12
    assert 2.48 < found.time_s[-1] < 2.5
    assert found.notes == ["the budget ends at 2.50 s: server took over a new parameter"]
    assert inconsistencies(traces, scenario) == []


def test_without_the_changes_neither_budget_nor_record_would_fit(changed):
    """The control: the parameters at the start for the whole session."""
    traces, scenario = changed
    constant = replace(scenario, changes="")
    assert worst(budget(traces, constant)) > 1e-5
    assert any("energy of motion" in text for text in inconsistencies(traces, constant))


def test_nothing_is_predicted_falsely_and_changes_are_events(changed):
    traces, scenario = changed
    found = summary(traces, scenario, budget(traces, scenario))
    assert found["passivity"]["passive"] is True
    assert [each["hit"] for each in found["outcomes"]] == [None]
    text = found["outcomes"][0]["text"]
    assert text.startswith("Parameters changed, first at 2.50 s: ")
    noted = [e for e in events.complete(traces, scenario) if e["kind"] == "parameter"]
    assert [event["time_s"] for event in noted] == [2.5, 2.9, 3.0, 3.4]
    assert noted[2]["what"] == "set server.contact_stiffness=3000.0"


def test_no_offset_is_judged_behind_a_change():
    other = carrying("2.5 server.impedance=8 master.impedance=8", task__kind="hold")
    traces = simulate_one(other)
    assert [each["hit"] for each in summary(traces, other)["outcomes"]] == [None]
    constant = replace(other, changes="")
    control = summary(traces, constant)["outcomes"]
    assert False in [each["hit"] for each in control]


@pytest.mark.parametrize(("at_s", "stable"), [(0.5, False), (4.1, None)])
def test_a_vibration_is_judged_from_the_last_change_on(at_s, stable):
    """Shortly before the end it is not known whether it decays."""
    scenario = carrying(f"{at_s} server.contact_damping=11", task__kind="hold")
    traces = oscillating(simulate_one(scenario), rms_m_s=20e-3, hertz=30.0)
    found = summary(traces, scenario)
    assert found["stable"] is stable
    assert ("a parameter changed 0.40 s before" in found["stability"]["text"]) is (stable is None)


def test_a_change_takes_effect_with_the_next_step_and_not_before():
    texts = "", "2.5 server.contact_damping=60"
    unchanged, changing = (simulate_one(carrying(text, 2.7)) for text in texts)
    differ = np.flatnonzero(unchanged.server.f_s[0][:, 0] != changing.server.f_s[0][:, 0])
    assert unchanged.server.time_s[differ[0]] == pytest.approx(2.504)  # the first step after it


def test_a_text_is_read_and_written_again():
    found = read_changes(" 4 server.object_mass=1 ; 2.5 server.impedance=null link.delay_s=2e-2")
    assert found == [
        Change(2.5, {"server.impedance": None, "link.delay_s": 0.02}),
        Change(4.0, {"server.object_mass": 1.0}),
    ]
    again = read_changes(changes_text([Change(1.0, {"server.coupling": "implicit"})]))
    assert again == [Change(1.0, {"server.coupling": "implicit"})]


def test_a_port_at_the_server_keeps_its_impedance_when_the_masters_changes():
    ((_, later),) = over_time(carrying("1 user1.master.impedance=40"))
    assert [user.impedance for user in later.users] == [40.0, 25.0]
    assert [user.server_impedance for user in later.users] == [25.0, 25.0]
    before = carrying("1 user1.master.rate_drop=4", channel="strict")
    ((_, later),) = over_time(before)
    assert later.users[0].contact is before.users[0].contact  # the server's stays as it is


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ("2.5 x", "must be 'TIME NAME=VALUE"),
        ("soon server.object_mass=1", "must be 0..inf s"),
        ("-1 server.object_mass=1", "must be 0..inf s"),
        ("1 server.object_mas=1", "did you mean server.object_mass"),
        ("1 server.object_mass=0", "object_mass = 0.0: must be 0.001..1000 kg"),
        ("1 server.contact_stiffness=1e9", "0..1e\\+07 N/m"),
        ("1 server.period_s=0.01", "server.period_s: can change on the strict channel only"),
        ("1 user1.master.rate_drop=3", "rate_drop: can change on the strict channel only"),
        ("1 device.mass=1", "device.mass: is fixed once a session runs"),
        ("1 server.coupling=unknown", "a black box and its port are fixed once running"),
        ("1 user5.server.impedance=3", "there is no user5"),
    ],
)
def test_what_cannot_change_is_refused_with_the_reason(changes, words):
    with pytest.raises(ScenarioError, match=words):
        carrying(changes)


CHANGE_NS, TICK_S = 3_000_000_000, 0.001


@pytest.mark.parametrize("impedance", [0.01, 1000.0])
def test_to_the_safety_limits_goes_what_limited_ticks_took_and_nothing_else(impedance):
    scenario = scenarios.load("carry_16ms", duration_s=5.0)
    session = SteppedSession(scenario)
    session.advance(CHANGE_NS)  # up to a frame start
    master = dataclasses.replace(scenario.users[0].master, impedance=impedance)
    session.users[0].loop.configure(master=master)
    session.run(lambda _: None)
    traces = session.traces()
    user = traces.users[0]
    power = (user.f_applied * user.xd_m)[:, 0] - (user.u_m**2 - user.v_m**2)[:, 0] / 2
    booked = budget(traces, scenario).parts["user1"]["safety"]
    assert booked[-1] == pytest.approx(np.sum(power) * TICK_S, abs=1e-6)
    assert 0.0 < np.abs(booked).max() < 0.1  # [J] of a grip that holds 2 mJ: no 1e281
    quiet = np.abs(user.f_applied - user.f_m)[:, 0] <= 1e-9
    before = slice(0, int(CHANGE_NS / 1e6))
    assert np.abs(power[before][quiet[before]]).max() < 1e-12
