# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A session has a folder, a domain and an environment of its own."""

import argparse
import os
import socket
import sys
from xml.etree import ElementTree

import pytest

from pmwvc_bringup.commands.node import node
from pmwvc_bringup.session.surroundings import (
    new_folder,
    node_environment,
    own_domain,
    own_environment,
    running_domains,
)
from pmwvc_core.errors import PmwvcError


def test_two_sessions_get_two_domains():
    with own_domain({}) as one, own_domain({}) as other:
        assert one != other
        assert 1 <= one <= 101


def test_running_sessions_of_this_machine_are_found_by_their_domains():
    with own_domain({}) as one, own_domain({}) as other:
        assert {one, other} <= set(running_domains())
    assert not {one, other} <= set(running_domains())


def test_a_domain_with_a_ros_program_in_it_is_left_alone():
    with own_domain({}) as first:
        pass
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


def test_the_users_choices_win_where_they_are_choices(tmp_path):
    given = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET", "ROS_LOG_DIR": "/elsewhere", "HOME": "/me"}
    found = node_environment(given, domain=7, log_folder=tmp_path)
    assert found["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "SUBNET"
    assert found["FASTDDS_BUILTIN_TRANSPORTS"] == "UDPv4"
    assert found["FASTRTPS_DEFAULT_PROFILES_FILE"].endswith("any_machine.xml")
    assert found["ROS_LOG_DIR"] == str(tmp_path)
    assert (found["ROS_DOMAIN_ID"], found["HOME"]) == ("7", "/me")


@pytest.mark.parametrize("given", [{}, {"ROS_AUTOMATIC_DISCOVERY_RANGE": "localhost"}])
def test_nodes_meet_on_this_machine_without_shared_memory(tmp_path, given):
    found = node_environment(given, domain=7, log_folder=tmp_path)
    assert found["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "SYSTEM_DEFAULT"
    profile = ElementTree.parse(found["FASTRTPS_DEFAULT_PROFILES_FILE"]).getroot()
    assert {element.text for element in profile.iter() if "address" in element.tag} == {
        "127.0.0.1"
    }
    assert [element.text for element in profile.iter() if element.tag.endswith("type")] == [
        "UDPv4"
    ]


def test_an_empty_variable_is_no_choice(tmp_path):
    found = node_environment({"AMENT_PREFIX_PATH": ""}, domain=7, log_folder=tmp_path)
    assert found["AMENT_PREFIX_PATH"] == sys.prefix


def test_sessions_of_one_second_get_folders_of_their_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    folders = {new_folder("a/../b c", None) for _ in range(5)}
    assert len(folders) == 5
    assert {os.path.dirname(folder) for folder in folders} == {"sessions"}


@pytest.mark.parametrize("given", [{}, {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}])
def test_a_node_by_hand_meets_other_machines_and_has_no_shared_memory(given):
    found = own_environment(given)
    assert found.get("ROS_AUTOMATIC_DISCOVERY_RANGE") == given.get("ROS_AUTOMATIC_DISCOVERY_RANGE")
    assert found["FASTDDS_BUILTIN_TRANSPORTS"] == "UDPv4"
    assert found["FASTRTPS_DEFAULT_PROFILES_FILE"].endswith("any_machine.xml")


def test_a_node_by_hand_on_this_machine_only_has_no_shared_memory_either():
    found = own_environment({"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"})
    assert found["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "SYSTEM_DEFAULT"
    assert found["FASTRTPS_DEFAULT_PROFILES_FILE"].endswith("this_machine.xml")


def test_transports_that_are_given_stay():
    given = {"FASTDDS_BUILTIN_TRANSPORTS": "LARGE_DATA"}
    assert own_environment(given)["FASTDDS_BUILTIN_TRANSPORTS"] == "LARGE_DATA"


@pytest.mark.parametrize(("given", "own_machine"), [(None, True), ("SUBNET", False)])
def test_a_node_started_by_hand_stays_on_this_machine_unless_set_otherwise(
    monkeypatch, given, own_machine
):
    monkeypatch.delenv("FASTRTPS_DEFAULT_PROFILES_FILE", raising=False)
    monkeypatch.delenv("ROS_AUTOMATIC_DISCOVERY_RANGE", raising=False)
    if given:
        monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", given)
    started = []
    monkeypatch.setattr(
        os, "execve", lambda program, words, environment: started.append(environment)
    )
    node.run(argparse.Namespace(kind="master", arguments=[]))
    profiles = started[0].get("FASTRTPS_DEFAULT_PROFILES_FILE", "")
    assert profiles.endswith("this_machine.xml") == own_machine
