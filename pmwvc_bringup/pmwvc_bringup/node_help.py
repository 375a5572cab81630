# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc node KIND --help``: the parameters of a node, as the node itself declares them."""

import contextlib
import textwrap
from collections.abc import Callable, Mapping
from typing import Any

import rclpy
from rclpy.node import Node

from pmwvc_analysis import recorder_node
from pmwvc_core.errors import ParameterError
from pmwvc_master import settings as master_settings
from pmwvc_netem import settings as netem_settings
from pmwvc_server import settings as server_settings

WIDTH = 99
EXAMPLES: Mapping[str, str] = {
    "master": "-r __ns:=/user1 -p side:=-1 -p device.plugin:=simulated",
    "server": "-p users:=\"['user1','user2']\" -p server.contact_stiffness:=800.0",
    "netem": "-p users:=\"['user1','user2']\" -p preset:=lte",
    "recorder": "-p users:=\"['user1','user2']\" -p folder:=my_session",
}
ONE_USER = "user1."
OF_ROS = ("start_type_description_service", "use_sim_time")  # what every ROS node declares


def _ignore(*_: Any) -> None:
    """Take a change of parameters and do nothing: nobody changes them here."""


def _recorder(node: Node) -> None:
    with contextlib.suppress(ParameterError):  # it wants a folder, once all is declared
        recorder_node.declare_settings(node)


DECLARE: Mapping[str, Callable[[Node], Any]] = {
    "master": lambda node: master_settings.declare_settings(node, _ignore, _ignore),
    "server": server_settings.declare_settings,
    "netem": lambda node: netem_settings.Settings(node, _ignore),
    "recorder": _recorder,
}


def text(kind: str) -> str:
    """Return the help of a node: how it is started, and every parameter with unit and range."""
    context = rclpy.Context()
    rclpy.init(args=[], context=context)
    try:
        node = Node(kind, context=context, start_parameter_services=False, enable_rosout=False)
        try:
            DECLARE[kind](node)
            lines = _parameters(node)
        finally:
            node.destroy_node()
    finally:
        rclpy.shutdown(context=context)
    head = [
        f"usage: pmwvc node {kind} [--ros-args [-r FROM:=TO] [-p NAME:=VALUE] [--params-file F]]",
        "",
        "example:",
        f"  pmwvc node {kind} --ros-args {EXAMPLES[kind]}",
        "",
        "parameters (default; unit and range; description):",
    ]
    return "\n".join([*head, *lines])


def _parameters(node: Node) -> list[str]:
    """Return one paragraph per parameter; settings of a single user are not repeated."""
    names = sorted(node.list_parameters([], 0).names)
    several = any(name.startswith(ONE_USER) for name in names)
    lines = []
    for name in names:
        descriptor = node.describe_parameter(name)
        if name not in OF_ROS and not name.startswith(("user1.", "user2.")):
            value = node.get_parameter(name).value
            lines.append(f"  {name} = {value!r}")
            words = [descriptor.description, descriptor.additional_constraints]
            about = "; ".join(word for word in words if word)
            lines += textwrap.wrap(about, WIDTH, initial_indent=" " * 6, subsequent_indent=" " * 6)
    if several:
        lines.append(
            f"  {ONE_USER}NAME sets a parameter listed above for one user, where users may differ"
        )
    return lines
