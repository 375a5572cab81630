# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A scenario is read completely or refused with every mistake named; dotted names: what they mean,
and that reader, ROS and variation agree on them.
"""

import pytest
from support.plain import load

from pmwvc_core.errors import ScenarioError
from pmwvc_core.params.names import leaves
from pmwvc_core.scenario.names import varied
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.scenario.scenario import PARAMETERS, Scenario, User, prefixed

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


@pytest.mark.parametrize(
    ("file", "overrides", "found"),
    [
        ({"master.impedance": 30}, {"user2.master.impedance": 40}, [30, 40]),
        ({"user2": {"master": {"impedance": 30}}}, {}, [25, 30]),
        ({"user2": {"master": {"impedance": 30}}}, {"master.impedance": 40}, [40, 40]),
    ],
)
def test_a_users_own_value_wins_and_a_later_source_wins_over_that(file, overrides, found):
    scenario = parse_scenario(BASE | file, overrides=overrides)
    assert [user.master.impedance for user in scenario.users] == found
    assert [user.side for user in parse_scenario(BASE, users=4).users] == [-1, 1, -1, 1]


def test_every_mistake_is_named_at_once():
    given = {"name": "pair", "users": 2, "cutof": 3, "user3": {"device": {"mass": 1}}}
    wrong = {"master": {"impedance": -3}, "server": {"couplin": "implicit"}}
    found = "\n".join(problems(given | wrong, overrides={"link.dely_s": 3}))
    for text in (
        "cutof = 3: there is no such parameter",
        "master.impedance = -3.0: must be 0.01..1000 N s/m",
        "user3: users = 2; raise users or remove it",
        "did you mean server.coupling?",
        "did you mean link.delay_s?",
    ):
        assert text in found


def test_what_a_file_leaves_out_has_defaults_also_the_coupling_by_the_environment():
    least = parse_scenario({})
    assert (least.controller, len(least.users), least.server.coupling) == ("pmwvc", 2, "implicit")
    for environment in ("hunt_crossley", "gel", "body"):
        given = {"server.environment": environment, "dof": 3 if environment == "body" else 1}
        assert parse_scenario(given).server.black_box
        (problem,) = problems(given, overrides={"server.coupling": "implicit"})
        assert problem.startswith(f"server.environment = {environment!r}: set server.coupling = u")


def test_the_number_of_a_column_is_taken_as_text():
    user = parse_scenario(BASE | {"operator": {"columns": 1}}).users[0]
    assert user.operator.columns == "1"
    (problem,) = problems(BASE | {"operator": {"columns": 1.5}})
    assert problem == "operator.columns = 1.5: must be a string"


FIRST = {"master.filter.kind": "first_order", "master.filter.pole_rad_s": 50}
TWO_FILTERS = {"master.velocity_filter.alpha": 0.5, "master.velocity_filter.cutoff_hz": 5.0}


@pytest.mark.parametrize(("settings", "said"), [
    ({"safety.fault_velocity": 0.01}, "safety.damper_velocity = 1.0: must be < fault_velocity"),
    ({"master.filter.kind": "butterworth"}, "master.filter.stop_hz = null: a Butterworth filter"),
    (TWO_FILTERS, "master.velocity_filter: alpha and cutoff_hz are given"),
    (FIRST | {"master.filter.stop_hz": 9}, "master.filter: pole_rad_s and stop_hz are given"),
    ({"master.filter.pole_rad_s": 50}, "master.filter.pole_rad_s = 50.0: integrate_and_dump has"),
    ({"server.period_s": 0.0085}, "server.period_s = 0.0085: must be a whole multiple"),
    ({"operator.kind": "playback_force"}, "user1.operator.file is missing: playback_force needs"),
    ({"user2.master.tick_s": 0.002}, "master.tick_s: [0.001, 0.002]: all users share one tick"),
    ({"user1.server.object_mass": 3}, "user1.server.object_mass = 3: server.object_mass is"),
])  # fmt: skip
def test_a_conflict_between_parameters_names_them_as_they_are_set(settings, said):
    found = problems({**BASE, **settings})
    assert [problem for problem in found if problem.startswith(said)], found


@pytest.mark.parametrize("name", ["link.delay_s", "user1.link.delay_s", "link.up.delay_s"])
def test_a_wrong_value_is_answered_once_by_the_name_that_was_given(name):
    assert problems(BASE, overrides={name: 100.0}) == [f"{name} = 100.0: must be 0..60 s"]


def test_every_parameter_of_a_group_has_one_home():
    shared, own = (
        [name for prefix, (_, kind) in prefixed(owner).items() for name in leaves(prefix, kind)]
        for owner in (Scenario, User)
    )
    assert sorted(name for name in PARAMETERS if "." in name) == sorted([*shared, *own])
    assert {name for name, each in PARAMETERS.items() if each.of_user} == {"side", *own}


def test_file_option_and_variation_set_the_same():
    by_option = load(
        "carry_16ms", settings_texts=["user2.link.delay_s=0.02", "server.object_mass=3"]
    )
    by_name = varied(load("carry_16ms"), "user2.link.delay_s", 0.02)
    by_name = varied(by_name, "server.object_mass", 3.0)
    assert by_option == by_name
