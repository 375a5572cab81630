# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The nodes of a scenario for ``ros2 launch``; ``pmwvc run`` also watches and reports.

::

    ros2 launch pmwvc_bringup session.launch.py scenario:=carry_16ms users:=2 duration:=20

The nodes wait until all are connected, then begin together (:mod:`pmwvc_bringup.session.starter`);
``duration`` counts from there. ``namespace:=lab`` puts all topics and nodes below ``/lab``.
They end with the launcher, however it ends: ``ros2 launch`` leaves them behind on SIGTERM.
"""

import sys

from launch import LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    ExecuteProcess,
    OpaqueFunction,
    RegisterEventHandler,
    Shutdown,
)
from launch.event_handlers import OnProcessExit
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from pmwvc_bringup import scenarios
from pmwvc_bringup.session import plan
from pmwvc_bringup.session.processes import ENDS_WITH_PARENT
from pmwvc_bringup.session.surroundings import new_folder

ARGUMENTS = {
    "scenario": ("carry_16ms", "name of a scenario, or a YAML file"),
    "users": ("", "number of users (empty: that of the scenario)"),
    "duration": ("", "length in s (empty: that of the scenario; 0: until interrupted)"),
    "record": ("true", "whether to record into the session folder"),
    "out": ("", "session folder (empty: sessions/<UTC time>-<scenario>)"),
    "view": ("false", "whether to serve the session's page"),
    "namespace": ("", "namespace of the whole session"),
}


def session_nodes(context):
    values = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    users = int(values["users"]) if values["users"] else None
    duration_s = float(values["duration"]) if values["duration"] else None
    scenario = scenarios.load(values["scenario"], users=users, duration_s=duration_s or None)
    record, view = (values[name].lower() in ("true", "1", "yes") for name in ("record", "view"))
    namespace = values["namespace"].strip("/")
    folder = new_folder(scenario.name, values["out"] or None)
    file = folder / "scenario.yaml"
    file.write_text(scenarios.to_yaml(scenario), "utf-8")
    (folder / "nodes").mkdir()
    actions, how = [], {"prefix": ENDS_WITH_PARENT, "output": "screen"}
    page = plan.Page() if view else None
    for node in plan.nodes(scenario, folder=folder, paused=True, page=page):
        if node.kind == "recorder" and not record:
            continue
        parameters = folder / "nodes" / f"{node.file_name}.yaml"
        parameters.write_text(node.parameter_file(), "utf-8")
        action = Node(
            package=plan.MODULES[node.kind].partition(".")[0],
            executable=node.kind,
            namespace="/".join(filter(None, (namespace, node.namespace))),
            parameters=[str(parameters)],
            exec_name=node.name,
            **how,
        )
        actions.append(action)
    endless = duration_s == 0.0
    words = [sys.executable, "-m", "pmwvc_bringup.session.starter", str(file)]
    words += ["--duration", "0" if endless else str(scenario.duration_s)]
    words += ["--namespace", namespace, *([] if record else ["--unrecorded"])]
    starter = ExecuteProcess(name="starter", cmd=words, **how)

    def over(event, _):
        if event.returncode:
            return [Shutdown(reason="the nodes did not begin")]
        reason = f"the {scenario.duration_s:g} s of the session are over"
        return [] if endless else [Shutdown(reason=reason)]

    handler = RegisterEventHandler(OnProcessExit(target_action=starter, on_exit=over))
    return [handler, *actions, starter]


def generate_launch_description():
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=text)
        for name, (default, text) in ARGUMENTS.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=session_nodes)])
