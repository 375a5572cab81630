# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The launch file gives ``pmwvc run`` what it was given; launch itself is stood in for."""

import runpy
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from pmwvc_bringup.cli import build_parser

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
