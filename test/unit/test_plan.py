# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The nodes of a session and the topics between them follow from the scenario; the launch file
gives ``pmwvc run`` what it was given; launch itself is stood in for.
"""

import runpy
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
import yaml
from support import plain as scenarios

from pmwvc_analysis.recording.topics import session_topics
from pmwvc_bringup.cli import build_parser
from pmwvc_bringup.session import plan
from pmwvc_core.errors import ScenarioError
from pmwvc_core.params import ContactParams, LinkParams, MasterParams
from pmwvc_core.params.names import flat_mapping
from pmwvc_core.runtime.parameter_values import built
from pmwvc_core.simulation.session import SteppedSession
from pmwvc_core.wave.impedance import largest_wave


def parameters_of(node):
    """Return the parameters of a node's file by dotted name."""
    return flat_mapping(yaml.safe_load(node.parameter_file())["/**"]["ros__parameters"])


@pytest.fixture
def scenario():
    return scenarios.load(
        "three_users", settings_texts=["user2.master.impedance=30", "user3.link.down.loss=0.5"]
    )


@pytest.fixture
def nodes(scenario, tmp_path):
    return {node.name: node for node in plan.nodes(scenario, folder=tmp_path)}


def test_nodes_start_in_order_and_all_but_the_recorder_wait(nodes):
    masters = ["user1 master", "user2 master", "user3 master"]
    assert list(nodes) == ["recorder", "netem", "server", *masters]
    assert [node.ros_name for node in nodes.values()][2:4] == ["/server", "/user1/master"]
    waiting = {name for name, node in nodes.items() if node.parameters.get("start.paused")}
    assert waiting == nodes.keys() - {"recorder"}
    words = nodes["user2 master"].command(Path("/x/user2.yaml"))
    assert words[1:] == [
        "-m", "pmwvc_master.node", "--ros-args", "-r", "__ns:=/user2", "--params-file",
        "/x/user2.yaml",
    ]  # fmt: skip


def test_every_node_gets_what_the_scenario_gives(scenario, nodes):
    user = scenario.users[1]
    master, server = (parameters_of(nodes[name]) for name in ("user2 master", "server"))
    netem = parameters_of(nodes["netem"])
    assert built("master", MasterParams, master) == user.master
    assert server["user2.master.impedance"] == user.server_impedance == 30.0
    assert built("user2.server", ContactParams, server) == user.contact
    assert server["users"] == netem["users"] == ["user1", "user2", "user3"]
    for each in scenario.users:
        assert built(f"{each.name}.link.up", LinkParams, netem) == each.link_up
        assert built(f"{each.name}.link.down", LinkParams, netem) == each.link_down


def test_topics_waited_for_are_those_recorded_and_the_waves(scenario):
    users = [user.name for user in scenario.users]
    links = [f"{user}/{direction}" for user in users for direction in ("up", "down")]
    topics = session_topics(users, links=links)
    recorded = {t.source for t in topics if t.essential or t.name.endswith("/reception")}
    waves = {t.name for t in topics if t.name != t.source}
    assert sorted(plan.topics(scenario)) == sorted(recorded | waves)


def test_a_live_session_refuses_changes_at_given_times(tmp_path):
    scenario = scenarios.load("wall", settings_texts=["changes=1 server.contact_stiffness=9"])
    with pytest.raises(ScenarioError, match="must be empty in a live session"):
        plan.nodes(scenario, folder=tmp_path)


TIMES = ("user1.safety.timeout_s=0.05", "user2.safety.timeout_s=0.2", "user2.safety.release_s=7")


def test_receivers_in_virtual_time_expect_what_live_ones_expect(tmp_path):
    settings = (*TIMES, "user2.master.impedance=40", "user1.server.impedance=10")
    scenario = scenarios.load("carry_16ms", settings_texts=settings)
    nodes = {node.kind: node for node in plan.nodes(scenario, folder=tmp_path)}
    live = nodes["server"].parameters
    batch = SteppedSession(scenario)
    assert live["safety.timeout_s"] == 0.2
    assert batch.server.p.release_s == live["safety.release_s"] == 7.0
    for simulated, user in zip(batch.users, scenario.users, strict=True):
        up, down = simulated.up.receiver, simulated.down.receiver
        assert up.silence_ns == round(live["safety.timeout_s"] * 1e9)  # alike for all users
        assert down.silence_ns == round(user.safety.timeout_s * 1e9)
        # Each port takes the longest wave of its own impedance.
        assert up.max_wave == largest_wave(user.server_impedance, waves=True)
        assert down.max_wave == largest_wave(user.impedance, waves=True)


FILE = Path(__file__).resolve().parents[2] / "pmwvc_bringup/launch/session.launch.py"


@pytest.fixture
def launched(monkeypatch):
    """Return what the launch file executes with arguments."""
    given = {}

    class LaunchConfiguration:
        def __init__(self, name):
            self.name = name

        def perform(self, _):
            return given[self.name]

    record = SimpleNamespace
    actions = record(
        DeclareLaunchArgument=lambda name, **options: record(name=name, **options),
        ExecuteProcess=record,
        OpaqueFunction=record,
        Shutdown=record,
    )
    for name, module in {
        "launch": record(LaunchDescription=list),
        "launch.actions": actions,
        "launch.substitutions": record(LaunchConfiguration=LaunchConfiguration),
    }.items():
        monkeypatch.setitem(sys.modules, name, module)

    def executed(**arguments):
        *declared, nodes = runpy.run_path(str(FILE))["generate_launch_description"]()
        given.update({each.name: each.default_value for each in declared} | arguments)
        (process,) = nodes.function(None)
        return process

    return executed


def test_a_launched_session_is_a_run_of_what_was_given_in_the_domain_of_the_launcher(
    launched, monkeypatch
):
    monkeypatch.setenv("ROS_DOMAIN_ID", "7")
    given = {"scenario": "wall", "users": "1", "duration": "2", "out": "there", "view": "true"}
    process = launched(**given)
    assert process.cmd[:3] == [sys.executable, "-m", "pmwvc_bringup"]
    words = build_parser().parse_args(process.cmd[3:])
    assert (words.scenario, words.users, words.duration, words.view) == ("wall", 1, 2.0, True)
    assert words.out == Path("there") and words.figures and not words.browser
    assert process.additional_env == {"ROS_DOMAIN_ID": "7"}


def test_a_launched_session_needs_nothing_and_then_runs_where_other_launched_nodes_do(
    launched, monkeypatch
):
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    process = launched()
    words = build_parser().parse_args(process.cmd[3:])
    assert (words.scenario, words.users, words.out) == ("carry_16ms", None, None)
    assert not words.view and process.additional_env == {"ROS_DOMAIN_ID": "0"}
