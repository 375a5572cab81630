# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A session has a folder, a domain and an environment of its own; files and plug-ins of its
scenario are looked at before anything starts.
"""

import argparse
import os
import re
import socket
import sys
from xml.etree import ElementTree

import pytest

from pmwvc_bringup import scenarios
from pmwvc_bringup.commands.node import node
from pmwvc_bringup.session import surroundings
from pmwvc_bringup.session.surroundings import (
    new_folder,
    node_environment,
    own_domain,
    own_environment,
)
from pmwvc_core.errors import PmwvcError, ScenarioError

RANGE, PROFILES = "ROS_AUTOMATIC_DISCOVERY_RANGE", "FASTRTPS_DEFAULT_PROFILES_FILE"
MOTION = str(scenarios.folders()[0] / "hand_motion.csv")


def test_a_domain_with_a_ros_program_in_it_is_left_alone():
    with own_domain({}) as first:
        assert 1 <= first <= 101
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as participant:
        participant.bind(("0.0.0.0", 7400 + 250 * first))
        with own_domain({}) as second:
            assert second != first
    with own_domain({}) as third:
        assert third == first


def test_the_users_domain_is_taken_once():
    with own_domain({}) as free:
        wish = {"ROS_DOMAIN_ID": str(free)}
        with pytest.raises(PmwvcError, match="another session runs there"), own_domain(wish):
            pass
    with own_domain(wish) as domain:
        assert domain == free


def test_an_error_inside_is_not_taken_for_a_taken_domain():
    with pytest.raises(ConnectionError, match="mine"), own_domain({}):
        raise ConnectionError("mine")


@pytest.mark.parametrize("wish", ["many", "-1", "233", "1.0"])
def test_a_domain_that_is_none_is_refused(wish):
    with pytest.raises(PmwvcError, match=f"ROS_DOMAIN_ID={wish}"):
        own_domain({"ROS_DOMAIN_ID": wish}).__enter__()


@pytest.mark.parametrize(
    ("given", "scope", "profile"),
    [
        ({}, None, "any_machine.xml"),
        ({RANGE: "SUBNET"}, "SUBNET", "any_machine.xml"),
        ({RANGE: "LOCALHOST"}, "SYSTEM_DEFAULT", "this_machine.xml"),
    ],
)
def test_a_node_by_hand_meets_whom_its_range_allows_without_shared_memory(given, scope, profile):
    found = own_environment(given)
    assert found.get(RANGE) == scope
    assert found[PROFILES].endswith(profile)
    assert found["FASTDDS_BUILTIN_TRANSPORTS"] == "UDPv4"
    given = {"FASTDDS_BUILTIN_TRANSPORTS": "LARGE_DATA"}
    assert own_environment(given)["FASTDDS_BUILTIN_TRANSPORTS"] == "LARGE_DATA"


@pytest.mark.parametrize(
    ("given", "scope", "profile"),
    [
        ({}, "SYSTEM_DEFAULT", "this_machine.xml"),
        ({RANGE: "localhost"}, "SYSTEM_DEFAULT", "this_machine.xml"),
        ({RANGE: "SUBNET", "HOME": "/me", "ROS_LOG_DIR": "/x"}, "SUBNET", "any_machine.xml"),
    ],
)
def test_nodes_of_a_session_meet_on_this_machine_unless_the_user_chooses(
    given, scope, profile, tmp_path
):
    found = node_environment({"AMENT_PREFIX_PATH": "", **given}, domain=7, log_folder=tmp_path)
    assert (found[RANGE], found["ROS_DOMAIN_ID"]) == (scope, "7")
    assert found["FASTDDS_BUILTIN_TRANSPORTS"] == "UDPv4"
    assert found["ROS_LOG_DIR"] == str(tmp_path)
    assert found.get("HOME") == given.get("HOME")
    assert found["AMENT_PREFIX_PATH"] == sys.prefix  # an empty variable is no choice
    assert found[PROFILES].endswith(profile)
    root = ElementTree.parse(found[PROFILES]).getroot()
    if profile == "this_machine.xml":
        assert {e.text for e in root.iter() if "address" in e.tag} == {"127.0.0.1"}
        assert [e.text for e in root.iter() if e.tag.endswith("type")] == ["UDPv4"]


@pytest.mark.parametrize(("given", "own_machine"), [(None, True), ("SUBNET", False)])
def test_a_node_started_by_hand_stays_on_this_machine_unless_set_otherwise(
    monkeypatch, given, own_machine
):
    for name in (PROFILES, RANGE):
        monkeypatch.delenv(name, raising=False)
    if given:
        monkeypatch.setenv(RANGE, given)
    started = []
    monkeypatch.setattr(os, "execve", lambda *words: started.append(words[-1]))
    node.run(argparse.Namespace(kind="master", arguments=[]))
    assert started[0].get(PROFILES, "").endswith("this_machine.xml") == own_machine


def test_sessions_of_one_second_get_folders_of_their_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    folders = {new_folder("a/../b c", None) for _ in range(5)}
    assert len(folders) == 5
    assert {os.path.dirname(folder) for folder in folders} == {"sessions"}


@pytest.mark.parametrize("name", scenarios.known())
def test_every_scenario_of_the_project_passes(name):
    assert surroundings.check(scenarios.load(name)) is None  # anything wrong raises


def problems(*texts, users=1):
    scenario = scenarios.load("carry_16ms", settings_texts=texts, users=users)
    with pytest.raises(ScenarioError) as caught:
        surroundings.check(scenario)
    return caught.value.problems


@pytest.mark.parametrize(
    ("texts", "words"),
    [
        (
            f"operator.kind=playback_motion operator.file={MOTION} operator.columns=7",
            "user1: .* no column '7'; there are time_s, left_m, right_m",
        ),
        (
            "server.coupling=unknown server.environment=moon",
            "server.environment = 'moon': not installed; there are: cube, wall",
        ),
        (
            "master.velocity_filter.kind=exact master.velocity_filter.share=0.99",
            "velocity_filter.share = 0.99: no high-pass filter of order 2",
        ),
    ],
)
def test_what_cannot_be_had_is_named_before_anything_starts(texts, words):
    (problem,) = problems(*texts.split())
    assert re.search(words, problem)


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


def test_the_simulated_device_needs_no_installed_package(monkeypatch):
    monkeypatch.setattr("pmwvc_core.plugins.entry_points", lambda group: ())
    surroundings.check(scenarios.load("carry_16ms"))
    (problem,) = problems("device.plugin=ros_topic")
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
