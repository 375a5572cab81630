# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The benchmark: the same seed gives the same table, and a session that fails stays in it."""

import csv
import dataclasses
import io
import math
import types

import numpy as np
import pytest
from benchmark import estimate
from benchmark.again import again
from benchmark.better import MEASURES, better, words
from benchmark.carry import placed_s
from benchmark.drawn import picture
from benchmark.intervals import median, ratio
from benchmark.kept import FILE, Kept
from benchmark.methods import METHODS
from benchmark.networks import Found, Group, found_in
from benchmark.probe import Probe, Rendered, rendered, wall_rendered
from benchmark.study import FULL, MEDIUM, SHORT, Plan, Study, study
from benchmark.swept import LEAST_J, page
from benchmark.trial import Outcome, Trial, run, scenario_of
from benchmark.walls import Grid, walls
from benchmark.written import sessions, table

from pmwvc_analysis.compare.settings import FAILED_COST
from pmwvc_core.network.presets import PRESETS

TINY = Plan(
    2, ("wifi_campus",), 1, ("wifi_campus", "thesis_lan_24"), 1, duration_s=4.0, probes=0,
    methods=("plain", "direct"),
)  # fmt: skip
SWEPT = ("ideal", "wifi_bad", "geo", "torture")  # no delay, jitter, a long delay, everything
# Eight stiffnesses, each 3.0 times the one before, from the softest to the stiffest of all.
COARSE = Grid(tuple(np.geomspace(10.0, 20000.0, 8)), 7, (1.0, 10.0, 100.0))


@pytest.fixture(scope="module")
def tiny():
    return study(TINY, 5, Kept(workers=1))


def test_the_same_seed_gives_the_same_table_and_another_one_does_not(tiny):
    again = study(dataclasses.replace(TINY, methods=("plain",)), 5, Kept(workers=1))
    mine = {trial: one for trial, one in tiny.judged.items() if trial.method == "plain"}
    assert again.judged == mine  # whatever else was run
    text = next(line for line in table(again).splitlines() if line.startswith("| `plain`"))
    assert text in table(tiny)
    other = study(dataclasses.replace(TINY, methods=("plain",)), 6, Kept(workers=1))
    assert text not in table(other)


def test_a_session_that_fails_is_counted_and_not_dropped(tiny):
    (row,) = tiny.of("direct", ["thesis_lan_24"])
    (failed,) = row
    assert math.isinf(failed.peak_n)
    assert failed.failure in ("diverged", "limited by safety")
    assert failed.cost == FAILED_COST
    assert math.isinf(failed.coherency_m)
    direct = next(line for line in table(tiny).splitlines() if line.startswith("| `direct`"))
    assert "| 100 % | 0 % | 1 of 1 | fails | fails | fails |" in direct
    assert direct.endswith(f"1 {failed.failure} |")
    failures = picture(tiny).panels[0]
    shares = dict(zip((dots.label for dots in failures.dots), failures.dots, strict=True))
    assert shares["direct"].y[0] == 100.0
    assert shares["plain"].y[0] == 0.0


def test_a_row_of_the_file_run_alone_gives_the_same_numbers_to_the_last_bit(tiny):
    rows = list(csv.DictReader(io.StringIO(sessions(tiny))))
    exact = ("energy_min_j", "coherency_m", "asymmetry")
    assert len(rows) == 4
    for row in rows[1:3]:
        found = again(row)
        assert len(found) == len(dataclasses.fields(Outcome))
        assert found == {name: row[name] for name in found}
    for row, outcome in zip(rows, tiny.judged.values(), strict=True):
        assert [float(row[n]) for n in exact] == [getattr(outcome, n) for n in exact]
    assert again(rows[1] | {"seed": "1"}) != again(rows[1])


def test_all_methods_meet_the_same_hands_and_packet_fates(tiny):
    trial = next(iter(tiny.judged))
    found = []
    for name, method in METHODS.items():
        settings = method.candidates(2, 1)[-1]
        of = dataclasses.replace(trial, method=name, settings=settings, network="torture")
        scenario = scenario_of(of)
        user = scenario.users[0]
        found.append((user.operator, user.link_up, scenario.task, scenario.seed))
    assert all(one == found[0] for one in found)


@pytest.mark.parametrize("plan", [FULL, MEDIUM, SHORT])
def test_no_judging_network_or_seed_was_searched(plan):
    assert set(plan.networks) == set(PRESETS)
    assert set(plan.training) < set(plan.networks)
    assert plan.training_seeds < 1000
    assert set(plan.methods) == set(METHODS)


def test_medians_and_shares_of_failed_sessions_and_how_often_an_interval_covers():
    values = np.array([[1.0, 2.0, np.inf], [3.0, np.inf, np.inf], [np.inf] * 3])
    assert math.isinf(median(values).value)
    assert median(np.ones((3, 4))) == (1.0, 1.0, 1.0)
    found = ratio(np.isinf(values).astype(float))
    assert found.value == pytest.approx(6 / 9)
    assert 0.2 < found.low < found.value < found.high == 1.0
    rng = np.random.default_rng(3)
    hits = [
        found.low <= 0.0 <= found.high
        for found in (
            median(rng.normal(size=(25, 1)) + 0.1 * rng.normal(size=(25, 3))) for _ in range(60)
        )
    ]
    assert np.mean(hits) > 0.85


def test_an_interrupted_study_goes_on_and_other_items_are_not_taken_for_its_own(tiny, tmp_path):
    trials = [trial for trial in tiny.judged if trial.method == "direct"]
    ran = []

    def counted(trial):
        ran.append(trial)
        return run(trial)

    first = Kept(tmp_path, workers=1).results(counted, trials[:1], Outcome)
    with (tmp_path / FILE).open("a") as file:
        file.write('["cut off in the mid')
    again = Kept(tmp_path, workers=1).results(counted, trials, Outcome)
    assert ran == trials  # each once
    assert again == {trial: tiny.judged[trial] for trial in trials}
    assert list(first) == trials[:1]
    other = dataclasses.replace(trials[0], duration_s=2.0)
    Kept(tmp_path, workers=1).results(counted, [other], Outcome)
    assert ran[-1] == other


def test_what_a_method_renders_is_measured_and_what_cannot_be_has_failed():
    known = rendered(Probe("plain", METHODS["plain"].settings, "thesis_lan_16", 1, 2.0), COARSE)
    assert 320.0 < known.stiffness_n_m < 420.0  # 1/500 + 43.5 ms/(2 b) would be 348 N/m at rest
    assert known.mass_kg == pytest.approx(0.25 + 25.0 * 0.0435 / 2.0, rel=0.02)
    assert known.stiffness_max_n_m == pytest.approx(20000.0)
    assert known.held_apart_m == pytest.approx(1.6 * 0.0435 / 50.0, rel=0.4)
    assert 0.0 < known.transparency < 1.0
    assert 0.8 < known.completion_s < 2.0  # its target takes 1 s
    assert known.z_width == known.z_width_passive == 1.0
    tuned = ("controller=pmwvc", "channel=plain", "master.position.gain=8")
    _, error = wall_rendered(Probe("plain", tuned, "ideal", 1, 2.0))
    assert error < known.transparency


def test_walls_on_which_a_direct_coupling_is_unstable_across_a_delay_do_not_count():
    direct = walls(METHODS["direct"].settings, "thesis_lan_16", 1, COARSE)
    assert 0.1 < direct.rendered < 0.5
    assert direct.rendered_passive == 0.0
    assert 100.0 < direct.stiffness_max_n_m < 1000.0  # 47 N/m without the hand


def test_a_cube_is_placed_once_it_stays_near_its_target():
    time_s = 0.01 * np.arange(400)
    target = np.where(time_s < 1.0, 0.0, 0.05)[:, None]

    def took(distance):
        server = types.SimpleNamespace(
            time_s=time_s, target=target, x_o=target + distance[:, None]
        )
        return placed_s(types.SimpleNamespace(server=server))

    late = np.where((time_s >= 1.0) & (time_s < 1.5), 0.02, 0.0)
    assert took(late) == pytest.approx(0.5)
    assert took(np.where(np.isclose(time_s, 2.5), -0.006, late)) == pytest.approx(1.51)
    assert took(np.where(time_s > 3.2, late, 0.02)) is None  # there for less than a second
    assert took(np.full(400, 0.02)) is None
    assert took(np.where(time_s > 3.0, np.nan, 0.0)) is None


def test_words_name_every_network_on_which_a_rival_is_better_and_no_other():
    plan = Plan(1, (), 1, ("ideal", "lan", "leo"), 1, probes=1, methods=("strict", "tdpa"))
    good = Outcome("", False, True, 0.0, *(1.0,) * 14)
    bad = dataclasses.replace(good, failure="diverged", coherency_m=np.inf, passive=False)
    close = dataclasses.replace(good, coherency_m=0.97, peak_n=0.5)
    shown = Rendered(*(1.0,) * 10)
    wide = dataclasses.replace(shown, z_width=0.5, completion_s=np.inf)

    def of(kind, ours, theirs):
        return {
            kind(name, (), network, 1, 1.0): one
            for name, found in (("strict", ours), ("tdpa", theirs))
            for network, one in zip(plan.networks, found, strict=True)
        }

    judged = of(Trial, (good, bad, good), (close, good, bad))
    of_both = Study(plan, 1, {}, judged, of(Probe, (wide, shown, shown), (shown, wide, shown)))
    found = {one.label: [p.network for p in better(of_both, "tdpa", one)] for one in MEASURES}
    better_in = {label: networks for label, networks in found.items() if networks}
    lan = {"failed [%]", "failed or restless [%]", "device less avatar [mm]"}
    ideal = {"peak force [N]", "walls rendered [%]", "completion time [s]"}
    assert set(better_in) == lan | ideal
    assert all(better_in[label] == ["lan" if label in lan else "ideal"] for label in better_in)
    assert "| failed [%] | 1: `lan` 0 (100) |" in words(of_both)
    worse = Study(plan, 1, {}, of(Trial, (good,) * 3, (good,) * 3), of(Probe, *[(wide,) * 3] * 2))
    assert words(worse) == "| better in | `tdpa` |\n| --- | --- |\n"


def test_the_strict_channel_gives_nothing_out_and_plain_does():
    found = {
        group: found_in(group)
        for group in (
            *(Group("strict", name, (7,), 2.0) for name in SWEPT),
            Group("plain", "wifi_bad", (1, 7), 6.0),
        )
    }
    least = {group.channel: min(one.least_j) for group, one in found.items()}
    assert all(min(one.least_j) >= LEAST_J for g, one in found.items() if g.channel == "strict")
    assert least["plain"] < 10.0 * LEAST_J
    text = page(found, "commit 1")
    assert f"`strict`: no balance below -1 nJ in any of {len(SWEPT)} sessions" in text
    below = sum(least < LEAST_J for least in list(found.values())[-1].least_j)
    assert below > 0
    assert f"`plain`: a balance below -1 nJ in {below} of 2 sessions, on 1 network: `wifi_" in text
    (row,) = (line for line in text.splitlines() if line.startswith("| wifi_bad "))
    assert row.split(" | ")[2] == f"0 of 1 / {below} of 2"


def test_what_an_interrupted_sweep_finished_and_how_long_a_plan_lasts_is_told():
    groups = [Group("strict", "lan", (1, 2), 1.0), Group("strict", "lan", (3,), 1.0)]
    kept = Kept(workers=1)
    kept.results(
        lambda group: Found([0.0] * len(group.seeds), [0.0], [1.0], [0.1]), groups[:1], Found
    )
    assert "in any of 2 sessions" in page(kept.finished(groups, Found), "commit 1")
    assert page(kept.finished(groups[1:], Found), "commit 1") == "No session has been finished.\n"
    told = estimate.words(dataclasses.replace(TINY, duration_s=0.5), 2)
    assert "2 methods, 2 settings of each on 1 network, judged on 2: 8 sessions of" in told
    assert "estimated: 1 minute on 2 cores" in told
