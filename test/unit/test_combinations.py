# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Every combination of values, and every mistake in them at once."""

import pytest

from pmwvc_bringup.combinations import (
    FEATURES,
    combinations,
    fitting,
    names,
    settings_of,
    variants_of,
)
from pmwvc_core.errors import ParameterError, ScenarioError
from pmwvc_core.simulation.session import simulate


def test_every_combination_comes_once_the_last_parameter_fastest():
    found = combinations(
        "carry_16ms",
        ["server.coupling=implicit,one_step_delay", "link.delay_s=0,0.008,0.024"],
        duration_s=2.0,
    )
    got = [(c.scenario.server.coupling, c.scenario.users[1].link_down.delay_s) for c in found]
    couplings = ("implicit", "one_step_delay")
    assert got == [(c, d) for c in couplings for d in (0.0, 0.008, 0.024)]
    assert found[1].label == "coupling = implicit, delay_s = 0.008"
    assert found[1].settings == {"server.coupling": "implicit", "link.delay_s": 0.008}
    assert {c.scenario.seed for c in found} == {found[0].scenario.seed}


def test_all_mistakes_are_reported_at_once_and_each_once():
    over = ["server.couplng=implicit", "link.delay_s=0,-1", "nothing", "dof=1", "dof=2"]
    with pytest.raises(ScenarioError) as caught:
        combinations("carry_16ms", [*over, "master.rate_drop=4,4"])
    problems = caught.value.problems
    for words in (
        "did you mean server.coupling?",
        "link.delay_s = -1",
        "--over nothing: must be name=a,b",
        "--over dof: is given twice",
        "--over master.rate_drop=4,4: a value is given twice",
    ):
        assert len([p for p in problems if words in p]) == 1, (words, problems)


def test_too_many_are_refused():
    values = ",".join(str(0.001 * n) for n in range(11))
    over = [f"link.delay_s={values}", f"task.move_s={values.replace('0.0,', '0.5,', 1)}"]
    with pytest.raises(ScenarioError, match="121 combinations: must be at most 100"):
        combinations("carry_16ms", over)


def test_controllers_are_the_axis_that_varies_fastest():
    found = combinations("wall", ["link.delay_s=0,0.01"], controllers=["direct", "waves"])
    got = [(c.scenario.users[0].link_up.delay_s, c.scenario.controller) for c in found]
    assert got == [(d, c) for d in (0.0, 0.01) for c in ("direct", "pmwvc")]
    assert found[1].settings == {"link.delay_s": 0, "controller": "waves"}


def test_every_word_gives_a_scenario_of_its_own():
    found = combinations("wall", [], controllers=names())
    assert [c.settings["controller"] for c in found] == names()
    plain = found[names().index("waves")].scenario
    for word, one in zip(names(), found, strict=True):
        if word in FEATURES and word != "waves":
            assert one.scenario != plain, word


def test_features_joined_are_all_there_and_what_is_not_named_is_off():
    (one,) = combinations("wall", [], controllers=["filter_bank+position"])
    master = one.scenario.users[0].master
    assert (master.bank.kind, master.position.feedback) == ("dissertation", "budgeted")
    assert master.position.gain == 20.0
    assert master.velocity_filter.kind == "none"
    assert one.scenario.server.compensation == "none"


def test_words_that_are_none_are_named_with_those_there_are():
    with pytest.raises(ScenarioError, match=r"'drect': must be one of pmwvc, direct.*ledger"):
        settings_of("drect", {})
    with pytest.raises(ScenarioError, match="different names"):
        variants_of("waves,waves")
    with pytest.raises(ScenarioError, match="give one of them"):
        combinations("wall", ["controller=direct"], controllers=["waves"])


@pytest.mark.parametrize("name", ["wall", "wall_slow", "wall_local_model", "carry_16ms"])
def test_a_velocity_filter_gets_the_order_that_suits_the_anti_aliasing_filter(name):
    words = ["velocity_filter", "velocity_filter_printed"]
    assert fitting(name, words, []) == (words, {})
    ours, printed = combinations(name, [], controllers=words)
    filters = [one.scenario.users[0].master.velocity_filter for one in (ours, printed)]
    assert [(f.kind, f.order) for f in filters] == [
        ("exact", 8 if name in ("wall_slow", "wall_local_model") else 2),
        ("equivalent", 1),
    ]


def test_what_a_scenario_cannot_have_is_left_out_with_its_reason():
    words = ["direct", "waves", "ledger", "tdpa"]
    kept, left_out = fitting("active_wall", words, [])
    assert kept == ["waves", "ledger"]
    assert set(left_out) == {"direct", "tdpa"}
    assert all("server.environment = 'active_wall'" in why for why in left_out.values())
    kept, left_out = fitting(
        "wall_slow", ["waves", "velocity_filter"], ["master.velocity_filter.order=3"]
    )
    assert kept == ["waves"]
    assert left_out["velocity_filter"].startswith("velocity_filter.share = 0.5")


def test_where_nothing_can_be_had_the_words_are_not_blamed():
    words = ["direct", "tdpa"]
    assert fitting("active_wall", words, []) == (words, {})
    found = combinations("active_wall", [], controllers=words, duration_s=0.1)
    with pytest.raises(ParameterError, match="active_wall"):
        simulate([one.scenario for one in found])
