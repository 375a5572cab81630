# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Every combination of values, and every mistake in them at once."""

import pytest

from pmwvc_bringup.comparison import combinations
from pmwvc_core.errors import ScenarioError


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
