# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A scenario is read completely or refused with every mistake named."""

import pytest

from pmwvc_core.errors import ScenarioError
from pmwvc_core.scenario.reader import parse_scenario

BASE = {"name": "pair", "duration_s": 5, "controller": "pmwvc", "channel": "plain", "users": 2}


def problems(mapping, **options):
    with pytest.raises(ScenarioError) as caught:
        parse_scenario(mapping, **options)
    return caught.value.problems


def test_a_value_below_link_means_both_directions():
    scenario = parse_scenario(BASE | {"link": {"delay_s": 0.008, "up": {"delay_s": 0.016}}})
    user = scenario.users[0]
    assert (user.link_up.delay_s, user.link_down.delay_s) == (0.016, 0.008)
    starred = parse_scenario(BASE, overrides={"link.*.loss": 0.25}).users[1]
    assert starred.link_up.loss == starred.link_down.loss == 0.25


def test_a_users_own_value_wins_over_the_common_one_and_leaves_the_others_alone():
    scenario = parse_scenario(
        BASE | {"server": {"contact_stiffness": 700}},
        overrides={"user2.server.contact_stiffness": 900},
    )
    assert [user.contact.contact_stiffness for user in scenario.users] == [700, 900]


def test_a_common_override_wins_over_a_users_value_in_the_file():
    scenario = parse_scenario(
        BASE | {"user2": {"master": {"impedance": 30}}}, overrides={"master.impedance": 40}
    )
    assert [user.master.impedance for user in scenario.users] == [40, 40]


def test_users_stand_on_alternating_sides():
    scenario = parse_scenario(BASE, users=4)
    assert [user.side for user in scenario.users] == [-1, 1, -1, 1]


def test_every_mistake_is_named_at_once_with_value_range_and_nearest_name():
    found = "\n".join(
        problems(
            {
                "name": "pair",
                "users": 2,
                "cutof": 3,
                "master": {"impedance": -3, "rate_drop": 0},
                "device": {"mass": -1.0},
                "user3": {"device": {"mass": 1}},
                "server": {"couplin": "implicit", "contact": "sticky"},
            },
            overrides={"link.dely_s": 3},
        )
    )
    for text in (
        "duration_s is missing",
        "controller is missing: must be one of pmwvc, direct",
        "cutof = 3: there is no such parameter",
        "master.impedance = -3.0: must be 0.01..1000 N s/m",
        "master.rate_drop = 0: must be 1..1000",
        "device.mass = -1.0: must be > 0 kg",
        "user3: users = 2; raise users or remove it",
        "did you mean server.coupling?",
        "server.contact = 'sticky': must be one of bilateral, grip",
        "did you mean link.delay_s?",
    ):
        assert text in found


def test_conflicts_between_right_values_are_named():
    twice = {"kind": "first_order", "pole_rad_s": 50, "stop_hz": 9}
    assert "take" in problems(BASE | {"master": {"filter": twice}})[0]
    unused = problems(BASE | {"master": {"filter": {"pole_rad_s": 50}}})[0]
    assert "integrate_and_dump has no cut-off; set kind = first_order" in unused
    assert "whole multiple" in problems(BASE | {"server": {"period_s": 0.0085}})[0]
    assert "needs a recording" in problems(BASE | {"operator": {"kind": "playback_force"}})[0]
    assert "share one tick" in problems(BASE | {"user2": {"master": {"tick_s": 0.002}}})[0]


def test_something_else_than_a_mapping_is_refused():
    assert problems(["carry"]) == ["list found where a mapping of names is expected"]


def test_a_shared_parameter_cannot_belong_to_one_user():
    assert "shared by all users" in problems(BASE, overrides={"user1.server.object_mass": 3})[0]


def test_the_number_of_a_column_is_taken_as_text():
    user = parse_scenario(BASE | {"operator": {"columns": 1}}).users[0]
    assert user.operator.columns == "1"
    (problem,) = problems(BASE | {"operator": {"columns": 1.5}})
    assert problem == "operator.columns = 1.5: must be a string"


@pytest.mark.parametrize(("settings", "said"), [
    ({"safety.fault_velocity": 0.01}, "safety.fault_velocity = 0.01: must be > damper_velocity"),
    ({"master.filter.kind": "butterworth"}, "master.filter.stop_hz = null: a Butterworth filter"),
    ({"server.environment": "gel"}, "server.environment = 'gel': set server.coupling = unknown"),
    (
        {"master.velocity_filter.alpha": 0.5, "master.velocity_filter.cutoff_hz": 5.0},
        "master.velocity_filter: alpha and cutoff_hz are given",
    ),
])  # fmt: skip
def test_a_conflict_between_parameters_names_them_as_they_are_set(settings, said):
    found = problems({**BASE, **settings})
    assert [problem for problem in found if problem.startswith(said)], found


@pytest.mark.parametrize("name", ["link.delay_s", "user1.link.delay_s", "link.up.delay_s"])
def test_a_wrong_value_is_answered_once_by_the_name_that_was_given(name):
    assert problems(BASE, overrides={name: 100.0}) == [f"{name} = 100.0: must be 0..60 s"]


def test_a_recording_of_before_may_name_the_mode_of_its_links():
    given = {"name": "old", "duration_s": 1, "controller": "pmwvc", "users": 2}
    parse_scenario(given | {"user1.link.up.mode": "exact", "link": {"down": {"mode": "exact"}}})
    with pytest.raises(ScenarioError, match=r"link.up.mode = 'netem'"):
        parse_scenario(given | {"user1.link.up.mode": "netem"})
