# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A replay of a simulated session is that session, through the file and back."""

import dataclasses

import numpy as np
import pytest

from pmwvc_analysis.recording.from_traces import record_traces
from pmwvc_analysis.recording.reader import read_scenario, read_session
from pmwvc_analysis.replay.run import exact, replay
from pmwvc_core.controllers.library import LIBRARY
from pmwvc_core.errors import RecordingError
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.simulation.session import simulate_one

BASE = {
    **{"name": "short", "duration_s": 1.6, "controller": "pmwvc", "channel": "plain", "users": 2},
    "task": {
        "kind": "carry",
        "grip_s": 0.1,
        "grip_rise_s": 0.2,
        "move_s": 0.4,
        "move_rise_s": 0.5,
    },
    "link": {
        **{"delay_s": 0.006, "jitter": "normal", "jitter_s": 0.003, "keep_order": False},
        **{"loss": 0.1, "duplicate": 0.1},
    },
}
SIGNALS = ("x_m", "xd_m", "f_h", "f_m", "f_applied", "u_m", "u_m_lp", "v_m")


def changed(scenario, **values):
    return parse_scenario(scenario.to_dict(), overrides=values)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A lossy simulated session on disk, as it is read."""
    folder = tmp_path_factory.mktemp("replay") / "session"
    scenario = parse_scenario(BASE)
    record_traces(folder, simulate_one(scenario), scenario)
    return folder


def replay_of(folder, scenario, **options):
    """Replay the session in a folder with another scenario."""
    return replay(read_session(folder), read_scenario(folder), scenario, **options)


def test_a_replay_of_the_recorded_force_is_the_recorded_session(recorded):
    """With the hand's own law: ``property/test_recordings.py``."""
    result = replay_of(recorded, read_scenario(recorded), hand="force")
    for one, other in zip(result.recorded.users, result.replayed.users, strict=True):
        assert np.abs(one.f_applied).max() > 0.5  # something was there to reproduce
        for name in SIGNALS:
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    server = result.replayed.server
    for name in ("x_o", "xd_o"):
        ours = getattr(result.recorded.server, name)
        np.testing.assert_array_equal(ours, getattr(server, name))
    for link, fates in result.recorded.fates.items():
        again = result.replayed.fates[link]
        assert fates.fate.tolist() == again.fate.tolist()
        assert fates.seq.tolist() == again.seq.tolist()
    assert {0, 1, 2} <= set(result.recorded.fates["user1/up"].fate.tolist())
    assert exact(result.differences)


@pytest.mark.parametrize("controller", LIBRARY)
def test_without_delay_the_first_packet_comes_at_time_zero_again(tmp_path, controller):
    scenario = parse_scenario(BASE | {"controller": controller, "link": {}})
    record_traces(tmp_path, simulate_one(scenario), scenario)
    result = replay_of(tmp_path, read_scenario(tmp_path))
    assert result.replayed.users[0].f_applied.max() > 0.5
    assert exact(result.differences)


def test_other_packet_fates_give_another_session(recorded):
    """The control: the same scenario with another seed is not the recorded session."""
    scenario = read_scenario(recorded)
    traces = read_session(recorded)
    luck = dataclasses.replace(scenario, seed=scenario.seed + 1)
    other = simulate_one(luck)
    gap = max(
        np.abs(one.f_applied - two.f_applied).max()
        for one, two in zip(traces.users, other.users, strict=True)
    )
    assert gap > 1e-3
    again = replay(traces, scenario, luck)  # the seed is of no account in a replay
    assert exact(again.differences)


def test_a_changed_parameter_is_what_a_simulation_with_the_same_network_does(recorded):
    """Fates do not depend on the impedance: replaying with it equals simulating with it."""
    scenario = changed(read_scenario(recorded), **{"master.impedance": 40.0})
    result = replay_of(recorded, scenario)
    direct = simulate_one(scenario)
    for one, other in zip(result.replayed.users, direct.users, strict=True):
        np.testing.assert_allclose(one.f_applied, other.f_applied, atol=1e-12)
    assert result.changes == {"master.impedance": 40.0}
    assert max(user["force_max_n"] for user in result.differences) > 1e-2


def test_a_replay_of_a_replay_is_the_replay(recorded, tmp_path):
    first = replay_of(recorded, read_scenario(recorded))
    record_traces(tmp_path, first.replayed, first.scenario)
    second = replay_of(tmp_path, read_scenario(tmp_path))
    assert second.recorded.source == "replayed"
    assert exact(second.differences)


def test_a_link_whose_settings_are_changed_is_simulated(recorded):
    scenario = changed(read_scenario(recorded), **{"user1.link.up.loss": 0.0})
    result = replay_of(recorded, scenario)
    assert 1 not in result.replayed.fates["user1/up"].fate
    assert 1 in result.replayed.fates["user1/down"].fate
    assert [
        note for note in result.prescribed.notes if note.startswith("user1/up: other settings")
    ]


def test_a_link_of_another_packet_rate_is_simulated(recorded):
    result = replay_of(recorded, changed(read_scenario(recorded), **{"master.rate_drop": 4}))
    assert "user1/up: other settings were given, so this link is simulated" in (
        result.prescribed.notes
    )
    assert {*result.prescribed.conditions.links} == {"user1/down", "user2/down"}


def test_a_server_of_another_period_steps_on_its_own_grid_from_the_recorded_start(recorded):
    result = replay_of(recorded, changed(read_scenario(recorded), **{"server.period_s": 0.004}))
    before, after = (t.server.time_s for t in (result.recorded, result.replayed))
    assert (before[1] - before[0], after[0]) == pytest.approx((0.008, before[0]))
    np.testing.assert_allclose(np.diff(after), 0.004)


@pytest.mark.parametrize(
    ("values", "words"),
    [({"users": 3}, "users = 3"), ({"dof": 2}, "dof = 2"), ({"master.tick_s": 0.002}, "tick_s")],
)
def test_what_a_replay_cannot_change_is_refused(recorded, values, words):
    with pytest.raises(RecordingError, match=words):
        replay_of(recorded, changed(read_scenario(recorded), **values))


def test_a_force_that_was_not_recorded_cannot_be_replayed(recorded):
    traces, scenario = read_session(recorded), read_scenario(recorded)
    traces.users[1].f_h[:] = np.nan
    with pytest.raises(RecordingError, match="user2: no force of the hand was recorded"):
        replay(traces, scenario, scenario, hand="force")
