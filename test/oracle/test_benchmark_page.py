# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What the benchmark's pages say: where a rival is better and why, and of the sweep."""

import dataclasses
import math

from benchmark import estimate
from benchmark.better import counted, listed, places, words
from benchmark.columns import OF_TASK, value_of
from benchmark.kept import Kept
from benchmark.networks import Found, Group, found_in
from benchmark.study import DEFAULTS, Plan, Study
from benchmark.swept import LEAST_J
from benchmark.swept import page as swept_page
from benchmark.trial import Outcome, Trial
from benchmark.walls import Asked, Walls
from benchmark.written import page

TINY = Plan(
    2, ("wifi_campus",), 1, ("wifi_campus", "thesis_lan_24"), 1, methods=("strict", "direct"),
    tasks=("carry", "free"),
)  # fmt: skip
SWEPT = ("ideal", "wifi_bad", "geo", "torture")  # no delay, jitter, a long delay, everything
GOOD = Outcome("", False, True, 0.0, *(1.0,) * 7, 0.0, *(None,) * 8)
OF_CARRY = {"path_error_m": 1.0, "completion_s": 1.0, "dropout_s": 0.0}
OF_CARRY |= {"grip_lost": 0.0, "absorbed": 0.0}


def drawn_up(ours, theirs, defaults, grids=((1.0, 1.0), (1.0, 1.0))):
    """Return a study of a carry on two networks, with these outcomes on each."""
    networks = ("ideal", "lan")
    plan = Plan(
        1, (), 1, networks, 1, walled=networks, methods=("strict", "tdpa"), tasks=("carry",)
    )
    each = (("strict", ours), ("tdpa", theirs), (DEFAULTS, defaults))
    judged = {
        Trial(name, (), "carry", network, 1, 1.0): dataclasses.replace(one, **own)
        for name, found in each
        for network, one in zip(networks, found, strict=True)
        for own in [{n: getattr(one, n) or v for n, v in OF_CARRY.items()}]
    }
    walled = {
        Asked(name, (), network, 1): Walls(share, share, 1.0)
        for name, row in zip(plan.methods, grids, strict=True)
        for network, share in zip(networks, row, strict=True)
    }
    chosen = dict.fromkeys(plan.methods, ())
    return Study(plan, 1, dict.fromkeys(plan.methods, 1), chosen, judged, walled)


def test_every_figure_in_which_a_rival_is_better_is_named_with_amount_and_reason():
    close = dataclasses.replace(GOOD, coherency_m=0.97)
    better = dataclasses.replace(GOOD, force_error_n=0.5, passive=False, energy_min_j=-0.004)
    defaults = dataclasses.replace(GOOD, force_error_n=0.6)
    found = drawn_up((GOOD, GOOD), (close, better), (GOOD, defaults), ((1.0, 0.5), (1.0, 1.0)))
    named = {(one.network, one.column.label): one for one in places(found, found.held_out)}
    assert set(named) == {("lan", "force error [N]"), ("lan", "walls rendered [%]")}
    text = words(found)
    assert "| carry | force error | 1 | `tdpa` 1 | energy 1, " in text
    assert "| walls | walls rendered | 1 | `tdpa` 1 |  |" in text
    rows = listed(found)
    assert "carry,lan,force error [N],tdpa,0.5,1,energy: 4 mJ; " in rows
    assert "; defaults: 0.6\n" in rows and "walls,lan,walls rendered [%],tdpa,100,50,\n" in rows
    assert "Another method is better in 2 of " in counted(found)
    assert "## Where `strict` is not the best" in page(found, "commit 1")
    same_all = drawn_up((GOOD,) * 2, (GOOD,) * 2, (GOOD,) * 2)
    assert words(same_all) == "Nowhere.\n"


def test_a_rival_that_does_not_work_does_not_count_and_that_is_said():
    shaky = dataclasses.replace(GOOD, force_error_n=0.1, restless=True)
    found = drawn_up((GOOD, GOOD), (shaky, GOOD), (GOOD, GOOD))
    assert words(found) == "Nowhere.\n"
    assert "better in 0 of " in counted(found) and "with those it would be 1." in counted(found)


def test_a_strict_session_that_fails_is_given_as_the_reason():
    lost = dataclasses.replace(
        GOOD, failure="task not done", coherency_m=math.inf, force_error_n=math.inf
    )
    found = drawn_up((GOOD, lost), (GOOD, GOOD), (GOOD, GOOD))
    text = listed(found)
    assert ",tdpa,0,100,fails: 1 of 1 (task not done)" in text and ",tdpa,1000,fails,fail" in text
    assert "`strict` has failed sessions on lan" in counted(found)
    position = OF_TASK["carry"][0]
    assert value_of(found.of("tdpa", "carry", ["lan"]), position) == 1e3


def test_the_strict_channel_gives_nothing_out_and_plain_does():
    found = {
        group: found_in(group)
        for group in (
            *(Group("strict", name, (7,), 2.0, compiled=False) for name in SWEPT),
            Group("plain", "wifi_bad", (1, 7), 4.0, compiled=False),
        )
    }
    least = {group.channel: min(one.least_j) for group, one in found.items()}
    assert all(min(one.least_j) >= LEAST_J for g, one in found.items() if g.channel == "strict")
    assert least["plain"] < 10.0 * LEAST_J
    text = swept_page(found, "commit 1")
    assert f"`strict`: no balance below -1 nJ in any of {len(SWEPT)} sessions" in text
    below = sum(least < LEAST_J for least in list(found.values())[-1].least_j)
    assert below > 0
    assert f"`plain`: a balance below -1 nJ in {below} of 2 sessions, on 1 network: `wifi_" in text
    (row,) = (line for line in text.splitlines() if line.startswith("| wifi_bad "))
    assert row.split(" | ")[1].startswith("0 / -")


def of_group(groups):
    return [Found([0.0] * len(group.seeds), [0.0], [1.0], [0.1]) for group in groups]


def test_what_an_interrupted_sweep_finished_and_how_long_a_plan_lasts_is_told():
    groups = [Group("strict", "lan", (1, 2), 1.0), Group("strict", "lan", (3,), 1.0)]
    kept = Kept(workers=1)
    kept.results(of_group, groups[:1], Found)
    assert "in any of 2 sessions" in swept_page(kept.finished(groups, Found), "commit 1")
    assert swept_page(kept.finished(groups[1:], Found), "c") == "No session has been finished.\n"
    told = estimate.words(TINY, 2)
    assert "2 methods at 2 tasks, 2 settings of each on 1 network, judged on 2: 16 sess" in told
    assert "about 1 minute on 2 cores" in told
    assert TINY.items(5) == 2 * (4 + 6)
