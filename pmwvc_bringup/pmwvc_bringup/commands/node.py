# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc node``: one node by itself, or its parameters as the node itself declares them."""

import argparse
import contextlib
import os
import signal
import sys
import textwrap
from collections.abc import Callable
from typing import TYPE_CHECKING

from pmwvc_bringup import command as cli
from pmwvc_core.errors import ParameterError

if TYPE_CHECKING:
    from rclpy.node import Node


WIDTH = 99
ROS_ARGUMENTS = {
    "master": "-r __ns:=/user1 -p side:=-1 -p device.plugin:=simulated",
    "server": "-p users:=\"['user1','user2']\" -p server.contact_stiffness:=800.0",
    "netem": "-p users:=\"['user1','user2']\" -p preset:=lte",
    "view": "-p port:=8080",
    "recorder": "-p users:=\"['user1','user2']\" -p folder:=my_session",
}
ONE_USER = "user1."
OF_ROS = ("start_type_description_service", "use_sim_time")  # declared by every ROS node


@cli.command(
    "node",
    "run one node by itself",
    """\
examples:
  pmwvc node server --ros-args -p users:="[user1, user2]"
  pmwvc node master --ros-args -r __ns:=/user1 --params-file user1.yaml
  pmwvc node master --help                     every parameter of a node
""",
    cli.argument("kind", choices=sorted(ROS_ARGUMENTS), help="which node"),
    cli.argument("arguments", nargs=argparse.REMAINDER, help="passed on to the node"),
)
def node(arguments: argparse.Namespace) -> cli.Result:
    """Become one node: same process, so that signals and exit code are the node's own.

    With ``--help``, print its parameters instead.
    """
    from pmwvc_bringup.session.plan import MODULES
    from pmwvc_bringup.session.surroundings import LOCALHOST, RANGE, own_environment, require_ros

    require_ros()
    if {"-h", "--help"} & set(arguments.arguments):
        print(parameter_help(arguments.kind))
        return cli.Result()
    words = [sys.executable, "-m", MODULES[arguments.kind], *arguments.arguments]
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})  # until the node can end by it
    os.execve(sys.executable, words, own_environment({RANGE: LOCALHOST, **os.environ}))


def parameter_help(kind: str) -> str:
    """Return the help of a node: how it is started, and every parameter with unit and range."""
    import rclpy
    from rclpy.node import Node

    context = rclpy.Context()
    rclpy.init(args=[], context=context)
    try:
        node = Node(kind, context=context, start_parameter_services=False, enable_rosout=False)
        try:
            _declarations()[kind](node)
            lines, names = [], sorted(node.list_parameters([], 0).names)
            for name in names:  # those of a single user are not repeated
                descriptor = node.describe_parameter(name)
                if name not in OF_ROS and not name.startswith(("user1.", "user2.")):
                    lines.append(f"  {name} = {node.get_parameter(name).value!r}")
                    words = [descriptor.description, descriptor.additional_constraints]
                    about = "; ".join(word for word in words if word)
                    lines += textwrap.wrap(
                        about, WIDTH, initial_indent=" " * 6, subsequent_indent=" " * 6
                    )
        finally:
            node.destroy_node()
    finally:
        rclpy.shutdown(context=context)
    head = [
        f"usage: pmwvc node {kind} [--ros-args [-r FROM:=TO] [-p NAME:=VALUE] [--params-file F]]",
        "",
        "example:",
        f"  pmwvc node {kind} --ros-args {ROS_ARGUMENTS[kind]}",
        "",
        "parameters (default; unit and range; description):",
    ]
    several = (
        f"  {ONE_USER}NAME sets a parameter listed above for one user, where users may differ"
    )
    tail = [several] if any(name.startswith(ONE_USER) for name in names) else []
    return "\n".join([*head, *lines, *tail])


def _declarations() -> "dict[str, Callable[[Node], object]]":
    """Return, by kind of node, the function that declares its parameters."""
    from pmwvc_analysis import recorder_node
    from pmwvc_master import settings as master_settings
    from pmwvc_netem import settings as netem_settings
    from pmwvc_server import settings as server_settings
    from pmwvc_view import node as view_node

    def recorder(node: "Node") -> None:
        with contextlib.suppress(ParameterError):  # no folder is given; all is declared before
            recorder_node.declare_settings(node)

    return {
        "master": lambda node: master_settings.declare_settings(node, _ignore, _ignore),
        "server": lambda node: server_settings.declare_settings(node, *[_ignore] * 4),
        "netem": lambda node: netem_settings.Settings(node, _ignore),
        "recorder": recorder,
        "view": view_node.declare_settings,
    }


def _ignore(*_: object) -> None:
    """Take a change of parameters and do nothing: none is made here."""
