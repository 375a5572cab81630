# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A live session for ``ros2 launch``: ``pmwvc run`` with what is given, its report included.

::

    ros2 launch pmwvc_bringup session.launch.py scenario:=carry_16ms users:=2 duration:=20

It runs in the ROS domain of the launcher. The launcher ends with it, and an interrupt of the
launcher ends it in order: it gets the time to write its report.
"""

import os
import sys

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration

ARGUMENTS = {
    "scenario": ("carry_16ms", "name of a scenario, or a YAML file"),
    "users": ("", "number of users (empty: that of the scenario)"),
    "duration": ("", "length in s (empty: that of the scenario)"),
    "out": ("", "session folder (empty: sessions/<UTC time>-<scenario>)"),
    "view": ("false", "whether to serve the session's page"),
}
REPORT_S = "120"  # for the nodes to end and the report to be written


def session(context):
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    words = [sys.executable, "-m", "pmwvc_bringup", "run", given["scenario"]]
    for name in ("users", "duration", "out"):
        words += [f"--{name}", given[name]] if given[name] else []
    words += ["--view", "--no-browser"] if given["view"].lower() in ("true", "1", "yes") else []
    domain = {"ROS_DOMAIN_ID": os.environ.get("ROS_DOMAIN_ID") or "0"}
    process = ExecuteProcess(
        cmd=words,
        name="session",
        output="screen",
        additional_env=domain,
        sigterm_timeout=REPORT_S,
        on_exit=[Shutdown(reason="the session is over")],
    )
    return [process]


def generate_launch_description():
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=text)
        for name, (default, text) in ARGUMENTS.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=session)])
