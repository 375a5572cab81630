# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The benchmark: the same seed gives the same tables, and a session that fails stays in them."""

import csv
import dataclasses
import io
import math
import types
from functools import partial

import numpy as np
import pytest
from benchmark.again import again, same
from benchmark.carry import completion_s
from benchmark.columns import OF_TASK
from benchmark.cost import path_error_m
from benchmark.drawn import picture
from benchmark.fast import pays
from benchmark.feel import held_share
from benchmark.intervals import median, ratio
from benchmark.kept import FILE, Kept
from benchmark.methods import METHODS
from benchmark.study import FULL, MEDIUM, SHORT, Plan, Study, compiled_of, study
from benchmark.tasks import TASKS
from benchmark.trial import Outcome, Trial, run
from benchmark.walls import Asked, Grid, walls
from benchmark.written import conditions, medians, sessions, table
from support.plain import load

from pmwvc_core.network.presets import PRESETS
from pmwvc_core.simulation.session import simulate_one

TINY = Plan(
    2, ("wifi_campus",), 1, ("wifi_campus", "thesis_lan_24"), 1, duration_s=3.2,
    methods=("strict", "direct"), tasks=("carry", "free"),
)  # fmt: skip
COARSE = Grid(tuple(np.geomspace(10.0, 20000.0, 3).tolist()), (1.0, 100.0))


@pytest.fixture(scope="module")
def tiny():
    return study(TINY, 5, Kept(workers=1))


def ran(trials, log):
    log += trials
    return [run(trial) for trial in trials]


def test_a_session_that_fails_is_counted_and_not_dropped(tiny):
    ((failed,),) = tiny.of("direct", "carry", ["thesis_lan_24"])
    assert failed.failure in ("diverged", "limited by safety")
    assert math.isinf(failed.peak_n) and math.isinf(failed.coherency_m)
    assert math.isinf(failed.completion_s) and failed.stiffness_n_m is None
    direct = next(line for line in table(tiny).splitlines() if line.startswith("| `direct`"))
    assert "| 100 | 0 | 100 | fails | fails |" in direct
    assert f"Failures: {failed.failure}." in table(tiny)
    assert "carry,direct,failed [%],100,100,100" in medians(tiny)
    assert "carry,direct,failed or restless [%],100,100,100" in medians(tiny)
    shares = {dots.label: dots for dots in picture(tiny).panels[0].dots}
    assert shares["direct"].y[0] >= 50.0
    assert shares["strict"].y[0] == 0.0


def test_a_row_of_the_file_run_alone_gives_the_same_numbers(tiny):
    rows = list(csv.DictReader(io.StringIO(sessions(tiny))))
    assert len(rows) == 2 * 2 * 3  # also with the defaults
    for row in (rows[0], rows[-1]):
        found = again(row)
        assert len(found) == len(dataclasses.fields(Outcome))
        assert found == {name: row[name] for name in found}
    other = again(rows[-1] | {"seed": "1"})
    assert not all(same(value, rows[-1][name]) for name, value in other.items())
    assert same("1.0", "1.0000001") and not same("1.0", "1.00001") and not same("", "1")


def test_all_methods_meet_the_same_hands_and_packet_fates():
    for task in TASKS:
        found = []
        for name, method in METHODS.items():
            settings = method.candidates(2, 1)[-1]
            scenario = Trial(name, settings, task, "torture", 1001, 4.0).scenario
            user = scenario.users[0]
            found.append((user.operator, user.link_up, scenario.task, scenario.seed))
        assert all(one == found[0] for one in found)


@pytest.mark.parametrize("plan", [FULL, MEDIUM, SHORT])
def test_no_judging_network_or_seed_was_searched(plan):
    assert set(plan.networks) == set(PRESETS)
    assert set(plan.training) < set(plan.networks)
    assert plan.training_seeds < 1000
    assert set(plan.methods) == set(METHODS)
    assert set(plan.tasks) == set(TASKS) == set(OF_TASK)


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
    trials = [t for t in tiny.judged if (t.method, t.task) == ("direct", "free")]
    log = []
    first = Kept(tmp_path, workers=1).results(partial(ran, log=log), trials[:1], Outcome)
    with (tmp_path / FILE).open("a") as file:
        file.write('["cut off in the mid')
    again = Kept(tmp_path, workers=1).results(partial(ran, log=log), trials, Outcome)
    assert log == trials  # each once
    assert again == {trial: tiny.judged[trial] for trial in trials}
    assert list(first) == trials[:1]
    other = dataclasses.replace(trials[0], duration_s=2.0)
    Kept(tmp_path, workers=1).results(partial(ran, log=log), [other], Outcome)
    assert log[-1] == other


def test_compiled_are_kinds_of_which_there_are_many(tiny):
    trial = next(iter(tiny.judged))
    many = [dataclasses.replace(trial, seed=seed, duration_s=10.0) for seed in range(40)]
    few = [dataclasses.replace(each, task="free") for each in many[:2]]
    found = compiled_of([*many, *few], [])
    assert trial in found and few[0] not in found
    changing = "master.deadband.kind=weber"  # its packets follow no plan, as those of a plug-in
    assert not pays(10**6, Trial("x", (changing,), "carry", "lan", 1, 1.0).scenario)
    assert pays(10**6, Trial("x", (), "carry", "lan", 1, 1.0).scenario)


def test_a_method_that_cannot_be_compiled_has_fewer_settings_and_the_page_says_so(monkeypatch):
    assert {len(each) for each in FULL.tried(1).values()} == {60}
    monkeypatch.setattr("benchmark.study.can_compile", lambda scenario: False)
    assert {len(each) for each in FULL.tried(1).values()} == {6}
    assert FULL.seeds_of("tdpa") == 2
    plan = dataclasses.replace(TINY, candidates=60)
    study = Study(plan, 5, {"strict": 60, "direct": 6}, {}, {}, {})
    assert "60 settings for each method (`direct` 6: interpreted, judged with 2" in conditions(
        study
    )


@pytest.fixture(scope="module")
def known():
    """Plain waves at each task on a constant link, and on none."""
    settings, found = METHODS["plain"].settings, {}
    for task, network in [(task, "thesis_lan_16") for task in TASKS] + [("wall", "ideal")]:
        found[task, network] = run(Trial("plain", settings, task, network, 1001, 6.0))
    return found


TAU_S, B = 0.0435, 25.0  # of plain waves on that link (docs/strict_channel.md)


def test_the_wall_felt_is_that_of_the_link_in_series_with_it(known):
    one = known["wall", "thesis_lan_16"]
    assert one.stiffness_n_m == pytest.approx(1.0 / (1.0 / 2000.0 + TAU_S / (2.0 * B)), rel=0.02)
    assert one.dropout_s == 0.0
    assert known["wall", "ideal"].stiffness_n_m > 1.5 * one.stiffness_n_m


def test_the_mass_moved_freely_is_that_of_the_link(known):
    one = known["free", "thesis_lan_16"]
    assert one.mass_kg == pytest.approx(B * TAU_S / 2.0, rel=0.05)
    assert abs(one.damping_n_s_m) < 0.5
    assert abs(one.lag_s) < 0.2 * TAU_S  # what is under way both ways is the same
    assert one.contact_n == 0.0
    direct = run(Trial("direct", ("controller=direct",), "free", "thesis_lan_16", 1001, 5.0))
    assert direct.lag_s == pytest.approx(0.016 + 0.5 * 0.008, abs=0.005)


def test_a_carry_has_an_offset_and_a_recorded_person_buzzes(known):
    carried, tapped = known["carry", "thesis_lan_16"], known["tapping", "thesis_lan_16"]
    assert carried.coherency_m == pytest.approx(1.6 * TAU_S / (2.0 * B), rel=0.4)
    assert 0.8 < carried.completion_s < 2.5  # the target takes 2 s
    assert carried.dropout_s == carried.grip_lost == 0.0
    assert tapped.buzz_n > 10.0 * carried.buzz_n
    assert carried.path_error_m > 1e-4
    wall = load("wall", duration_s=1.5)  # where nothing is carried
    assert tapped.path_error_m is None and path_error_m(simulate_one(wall), wall) == 0.0
    assert not any(one.failure or one.restless for one in known.values())


def test_walls_on_which_a_direct_coupling_is_unstable_across_a_delay_do_not_count():
    settings = METHODS["direct"].settings
    direct = walls(Asked("direct", settings, "thesis_lan_16", 1, COARSE))
    assert 0.1 < direct.rendered < 0.9
    assert direct.rendered_passive == 0.0
    assert direct.stiffness_max_n_m < 1000.0  # 47 N/m without the hand


def test_a_move_is_completed_once_the_cube_stays_near_its_end():
    time_s = 0.01 * np.arange(700)
    task = types.SimpleNamespace(move_rise_s=1.0, rest_s=1.0)
    target = np.where(time_s < 1.0, 0.0, np.minimum(time_s - 1.0, 1.0) * 0.05)[:, None]

    def took(distance):
        server = types.SimpleNamespace(
            time_s=time_s, target=target, x_o=target + distance[:, None], period_s=0.01
        )
        of = types.SimpleNamespace(server=server)
        return completion_s(of, types.SimpleNamespace(task=task))

    nothing = np.zeros(700)
    assert took(nothing) == pytest.approx(0.9, abs=0.02)  # 45 of 50 mm; the later of two moves
    late = np.where((time_s - 1.005) % 2.0 < 1.5, 0.02, 0.0)
    assert took(late) == pytest.approx(1.5, abs=0.02)
    assert math.isinf(took(np.full(700, 0.02)))
    assert math.isinf(took(np.where(time_s > 3.0, np.nan, 0.0)))


def test_buzz_at_the_rate_of_packets_is_told_from_other_noise():
    time_s = 1e-3 * np.arange(4000)
    tones = (125.0, 250.0, 90.0, 10.0)
    user = types.SimpleNamespace(time_s=time_s, tick_s=1e-3)
    known = types.SimpleNamespace(master=types.SimpleNamespace(frame_s=0.008))
    server = types.SimpleNamespace(period_s=0.008)
    scenario = types.SimpleNamespace(users=[known], server=server)

    def share(*sizes):
        user.f_applied = sum(
            size * np.sin(2.0 * np.pi * hertz * time_s)
            for size, hertz in zip(sizes, tones, strict=True)
        )[:, None]
        return held_share(types.SimpleNamespace(users=[user]), scenario)

    assert share(1.0, 1.0, 0.0, 5.0) == pytest.approx(1.0, abs=0.01)
    assert share(1.0, 0.0, 1.0, 5.0) == pytest.approx(0.5, abs=0.01)
    assert share(0.0, 0.0, 1.0, 5.0) == pytest.approx(0.0, abs=0.01)
