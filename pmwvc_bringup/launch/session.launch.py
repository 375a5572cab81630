# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The nodes of a scenario for ``ros2 launch``; ``pmwvc run`` also orders, watches and reports.

::

    ros2 launch pmwvc_bringup session.launch.py scenario:=carry_16ms users:=2 duration:=20

The nodes begin as soon as they are up, without waiting for each other.
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown, TimerAction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from pmwvc_bringup import plan, scenarios
from pmwvc_bringup.surroundings import new_folder

ARGUMENTS = {
    "scenario": ("carry_16ms", "name of a scenario, or a YAML file"),
    "users": ("", "number of users (empty: as the scenario says)"),
    "duration": ("", "length in s (empty: as the scenario says; 0: until interrupted)"),
    "record": ("true", "whether to record into the session folder"),
    "out": ("", "session folder (empty: sessions/<UTC time>-<scenario>)"),
}


def session_nodes(context):
    values = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    users = int(values["users"]) if values["users"] else None
    duration_s = float(values["duration"]) if values["duration"] else None
    scenario = scenarios.load(values["scenario"], users=users, duration_s=duration_s or None)
    record = values["record"].lower() in ("true", "1", "yes")
    folder = new_folder(scenario.name, values["out"] or None)
    (folder / "scenario.yaml").write_text(scenarios.to_yaml(scenario), "utf-8")
    (folder / "nodes").mkdir()
    actions = []
    for node in plan.nodes(scenario, folder=folder, paused=False):
        if node.kind == "recorder" and not record:
            continue
        file = folder / "nodes" / f"{node.file_name}.yaml"
        file.write_text(node.parameter_file(), "utf-8")
        actions.append(
            Node(
                package=plan.MODULES[node.kind].partition(".")[0],
                executable=node.kind,
                namespace=node.namespace,
                parameters=[str(file)],
                output="screen",
            )
        )
    if duration_s != 0.0:
        over = Shutdown(reason=f"the {scenario.duration_s:g} s of the session are over")
        actions.append(TimerAction(period=scenario.duration_s, actions=[over]))
    return actions


def generate_launch_description():
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=text)
        for name, (default, text) in ARGUMENTS.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=session_nodes)])
