# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The nodes of a scenario for ``ros2 launch``; ``pmwvc run`` also orders, watches and reports."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from pmwvc_bringup import plan, scenarios
from pmwvc_bringup.surroundings import new_folder


def session_nodes(context):
    values = {
        name: LaunchConfiguration(name).perform(context) for name in ("scenario", "users", "out")
    }
    users = int(values["users"]) if values["users"] else None
    scenario = scenarios.load(values["scenario"], users=users)
    folder = new_folder(scenario.name, values["out"] or None)
    (folder / "scenario.yaml").write_text(scenarios.to_yaml(scenario), "utf-8")
    (folder / "nodes").mkdir()
    actions = []
    for node in plan.nodes(scenario, folder=folder, paused=False):
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
    return actions


def generate_launch_description():
    arguments = {
        "scenario": ("carry_16ms", "name of a scenario, or a YAML file"),
        "users": ("", "number of users (empty: as the scenario says)"),
        "out": ("", "session folder (empty: sessions/<UTC time>-<scenario>)"),
    }
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=text)
        for name, (default, text) in arguments.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=session_nodes)])
