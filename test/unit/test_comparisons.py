# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The combinations of a comparison, the parameters of each controller in it, and its
conclusions.
"""

import re

import pytest
from support.plain import load

from pmwvc_analysis.compare.measures import MEASURES, Compared
from pmwvc_analysis.compare.settings import parameters_of, tuning_of
from pmwvc_analysis.report import comparison as files
from pmwvc_analysis.report.comparison import row
from pmwvc_bringup import comparison as report
from pmwvc_bringup.comparison import combinations
from pmwvc_core.errors import ScenarioError
from pmwvc_core.traces import SessionTraces

MATRIX = "30 2; 2 20"


def test_a_rule_that_the_parameters_miss_is_named():
    words = ["controller=virtual_coupling", "operator.kind=none", "device.damping=0"]
    scenario = load("carry_16ms", settings_texts=words)
    assert tuning_of(scenario).startswith("misses rule colgate by")
    words = ["controller=virtual_coupling", "baseline.virtual_coupling.stiffness=30"]
    assert tuning_of(load("carry_16ms", settings_texts=words)) == "meets its rules"


def shown(name, *settings):
    return parameters_of(load(name, settings_texts=settings))


def test_parameters_shown_are_those_of_the_controller_alone():
    waves = shown("carry_16ms")
    assert {"master.impedance", "master.hold", "server.coupling"} <= set(waves)
    assert not any("compensation" in name or "baseline" in name for name in waves)
    two = shown("carry_16ms", "controller=pspm", "user2.baseline.pspm.damping=3")
    assert two["user2.baseline.pspm.damping"] == 3.0
    direct = load("direct_16ms")
    assert (parameters_of(direct), tuning_of(direct)) == ({}, None)


@pytest.mark.parametrize(
    ("whose", "expected"),
    [
        ("user2.", {"master.impedance": 25.0, "user2.master.impedance_matrix": MATRIX}),
        ("", {"master.impedance_matrix": MATRIX}),
    ],
)
def test_an_impedance_matrix_is_shown_in_place_of_the_number(whose, expected):
    found = shown("carry_16ms", "dof=2", f"{whose}master.impedance_matrix={MATRIX}")
    assert {k: v for k, v in found.items() if "impedance" in k} == expected


def entry(controller, delay_s=0.016, **measures):
    scenario = load("wall", settings_texts=[f"link.delay_s={delay_s}"])
    settings = {"link.delay_s": delay_s, "controller": controller}
    traces = SessionTraces(source="simulated", duration_s=1.0, users=[], server=None)
    rest = {"stable": True, "passive": True, **measures}
    return Compared(
        controller, settings, traces, scenario, measures=dict.fromkeys(MEASURES) | rest
    )


def test_a_session_that_was_not_judged_is_neither_stable_nor_unstable():
    entries = [entry("waves", coherency_rms_m=1e-3), entry("tdpa", stable=None, passive=None)]
    entries[1].measures["coherency_rms_m"] = 2e-3
    page = files.render("two", entries, {}, [])
    judged, open_ = re.findall(r'<td class="(good|fail|)">(.*?)</td>', page)
    assert judged == ("good", "✓ stable")
    assert open_ == ("", "? stability not judged, passivity not judged")
    sessions = [row(one) for one in entries]
    _, first, second, *_ = report.lines({"sessions": sessions})
    assert first.endswith("  stable")
    assert second.endswith("  not judged, passivity not judged")


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
