# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Files and plug-ins of a scenario are looked at before anything starts."""

import pytest

from pmwvc_bringup import scenarios
from pmwvc_bringup.session import surroundings
from pmwvc_core.errors import PmwvcError, ScenarioError

MOTION = str(scenarios.folders()[0] / "hand_motion.csv")


def problems(*texts, users=2):
    scenario = scenarios.load("carry_16ms", settings_texts=texts, users=users)
    with pytest.raises(ScenarioError) as caught:
        surroundings.check(scenario)
    return caught.value.problems


@pytest.mark.parametrize("name", scenarios.known())
def test_every_scenario_of_the_project_passes(name):
    assert surroundings.check(scenarios.load(name)) is None  # anything wrong raises


def test_a_wrong_column_is_answered_with_those_there_are():
    (problem,) = problems(
        "operator.kind=playback_motion", f"operator.file={MOTION}", "operator.columns=7"
    )
    assert problem.startswith("user1: ")
    assert "no column '7'; there are time_s, left_m, right_m" in problem


def test_everything_wrong_is_reported_at_once_and_with_its_user(tmp_path):
    garbage = tmp_path / "delays.csv"
    garbage.write_bytes(bytes(range(256)))
    found = problems(
        "user1.device.plugin=falcom",
        "user2.operator.kind=playback_force",
        "user2.operator.file=nowhere.csv",
        "link.jitter=trace",
        f"link.trace_file={garbage}",
        "user3.link.up.trace_file=gone.txt",
        users=3,
    )
    starts = [
        "user1: device.plugin = 'falcom': not installed; there are: ",
        f"user1: {garbage}: not text",
        "user2: nowhere.csv: no such file",
        "user3: gone.txt: cannot be read as a delay trace: No such file",
    ]
    assert len(found) == len(starts)
    for problem, start in zip(found, starts, strict=True):
        assert problem.startswith(start)


def test_an_environment_that_is_not_installed_is_refused_before_anything_starts():
    (problem,) = problems("server.coupling=unknown", "server.environment=moon", users=1)
    assert problem.startswith("server.environment = 'moon': not installed; there are: cube, wall")


def test_a_controller_that_cannot_use_a_black_box_is_named():
    (problem,) = problems(
        "controller=direct",
        "server.coupling=unknown",
        "server.environment=active_wall",
        users=1,
    )
    assert problem.endswith("needs controller = pmwvc (direct supports only cube and wall)")


def test_the_simulated_device_needs_no_installed_package(monkeypatch):
    monkeypatch.setattr("pmwvc_core.plugins.entry_points", lambda group: ())
    surroundings.check(scenarios.load("carry_16ms"))
    (problem,) = problems("device.plugin=ros_topic", users=1)
    assert "not installed; there are: none" in problem


def test_without_ros_the_answer_names_the_remedy(monkeypatch):
    monkeypatch.setattr(surroundings.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(PmwvcError, match=r"no rclpy.*make setup.*'pmwvc simulate'"):
        surroundings.require_ros()


def test_a_simulation_states_which_device_it_leaves_out():
    scenario = scenarios.load("carry_16ms", settings_texts=["user2.device.plugin=ros_topic"])
    surroundings.check(scenario)
    (note,) = surroundings.notes(scenario)
    assert note.startswith("user2: a simulated device replaces device.plugin = 'ros_topic'")


def test_a_filter_that_cannot_be_designed_is_refused_before_anything_starts():
    (problem,) = problems(
        "master.velocity_filter.kind=exact", "master.velocity_filter.share=0.99", users=1
    )
    assert "velocity_filter.share = 0.99: no high-pass filter of order 2" in problem


@pytest.mark.parametrize(
    ("users", "cores", "busy", "needed"),
    [
        (2, 2, 0.3, None),
        (6, 2, 0.0, None),
        (8, 2, 0.0, "2.4"),
        (8, 4, 0.5, None),
        (2, 2, 3.5, "0.6"),
    ],
)
def test_a_session_that_the_cores_cannot_carry_is_warned_of_with_the_number(
    users, cores, busy, needed
):
    scenario = scenarios.load("carry_16ms", users=users)
    found = surroundings.too_much(scenario, cores=cores, busy=busy)
    assert bool(found) == bool(needed)
    assert all(f"needs about {needed} cores; this machine has {cores}" in text for text in found)
