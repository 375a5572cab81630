# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The benchmark: the same seed gives the same table, and a session that fails stays in it."""

import csv
import dataclasses
import io
import math

import numpy as np
import pytest
from benchmark.drawn import picture
from benchmark.intervals import median, ratio
from benchmark.kept import FILE, Kept
from benchmark.methods import METHODS
from benchmark.networks import LEAST_J, Group, found_in
from benchmark.networks import table as table_of_networks
from benchmark.probe import Probe, rendered
from benchmark.study import FULL, MEDIUM, SHORT, Plan, study
from benchmark.trial import FAILED_COST, Outcome, run, scenario_of
from benchmark.written import sessions, table

from pmwvc_core.network.presets import PRESETS

TINY = Plan(
    2,
    ("wifi_campus",),
    1,
    ("wifi_campus", "thesis_lan_24"),
    1,
    duration_s=4.0,
    probes=0,
    methods=("plain", "direct"),
)


@pytest.fixture(scope="module")
def tiny():
    return study(TINY, 5, Kept(workers=1))


def test_the_same_seed_gives_the_same_table_and_another_one_does_not(tiny):
    again = study(dataclasses.replace(TINY, methods=("plain",)), 5, Kept(workers=1))
    mine = {trial: one for trial, one in tiny.judged.items() if trial.method == "plain"}
    assert again.judged == mine  # whatever else was run
    text = table(again).splitlines()[2]
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
    assert "100 % (100 to 100) | 0 % (0 to 0) | 1 of 1 | fails (fails to fails)" in direct
    assert direct.endswith(f"1 {failed.failure} |")
    failures = picture(tiny).panels[0]
    shares = dict(zip((dots.label for dots in failures.dots), failures.dots, strict=True))
    assert shares["direct"].y[0] == 100.0
    assert shares["plain"].y[0] == 0.0


def test_every_row_of_the_file_can_be_run_again(tiny):
    rows = list(csv.DictReader(io.StringIO(sessions(tiny))))
    assert len(rows) == 4
    for trial, written in zip(tiny.judged, rows, strict=True):
        assert written["settings"].split() == list(trial.settings)
        assert (written["network"], int(written["seed"])) == (trial.network, trial.seed)
    trial = next(trial for trial in tiny.judged if trial.method == "direct")
    assert run(trial) == tiny.judged[trial]


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


def test_the_median_of_mostly_failed_sessions_is_a_failure():
    values = np.array([[1.0, 2.0, np.inf], [3.0, np.inf, np.inf], [np.inf] * 3])
    assert math.isinf(median(values).value)
    assert median(np.ones((3, 4))) == (1.0, 1.0, 1.0)
    found = ratio(np.isinf(values).astype(float))
    assert found.value == pytest.approx(6 / 9)
    assert 0.2 < found.low < found.value < found.high == 1.0


def test_the_interval_of_a_median_covers_it_as_often_as_it_says():
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
    known = rendered(Probe("plain", METHODS["plain"].settings, "thesis_lan_16", 1, 2.0))
    assert 320.0 < known.stiffness_n_m < 420.0  # 1/500 + 43.5 ms/(2 b) would be 348 N/m at rest
    assert known.mass_kg == pytest.approx(0.25 + 25.0 * 0.0435 / 2.0, rel=0.02)
    assert known.stiffness_max_n_m > 1000.0
    assert known.held_apart_m == pytest.approx(1.6 * 0.0435 / 50.0, rel=0.4)
    assert 0.0 < known.transparency < 1.0
    tuned = ("controller=pmwvc", "channel=plain", "master.position.gain=8")
    assert rendered(Probe("plain", tuned, "ideal", 1, 2.0)).transparency < known.transparency


def test_the_strict_channel_gives_nothing_out_on_any_network_and_plain_does():
    found = {
        group: found_in(group)
        for group in (
            *(Group("strict", name, (7,), 2.0) for name in PRESETS),
            Group("plain", "wifi_bad", (1, 7), 6.0),
        )
    }
    least = {group.channel: min(one.least_j) for group, one in found.items()}
    assert all(min(one.least_j) >= LEAST_J for g, one in found.items() if g.channel == "strict")
    assert least["plain"] < 10.0 * LEAST_J
    text = table_of_networks(
        {group: one for group, one in found.items() if group.network == "wifi_bad"}
    )
    strict, plain = text.splitlines()[2:]
    assert strict.startswith("| wifi_bad | `strict` | 1 | 0 | 0 |")
    assert plain.split(" | ")[4] != "0"
