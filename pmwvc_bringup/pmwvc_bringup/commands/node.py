# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Commands for live sessions: ``pmwvc view``, a session in the browser, also one that was recorded
or is simulated in real time; and ``pmwvc node``, one node by itself, or its parameters as the node
declares them.
"""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from pmwvc_bringup import command as cli
from pmwvc_bringup.output import terminal
from pmwvc_core.errors import PmwvcError, RecordingError

if TYPE_CHECKING:
    from pmwvc_view.session import Session
import contextlib
import os
import signal
import sys
import textwrap
from collections.abc import Callable
from typing import TYPE_CHECKING

from pmwvc_core.errors import ParameterError

if TYPE_CHECKING:
    from rclpy.node import Node


WHAT = "a session folder, or a scenario to simulate in real time (nothing: a session that runs)"


def _sessions(**given: object) -> list[str]:
    """Return what can be viewed: scenarios and folders."""
    return [*cli.scenario_names(), *cli.session_folders(**given)]  # type: ignore[arg-type]


@cli.command(
    "view",
    "show a session in the browser and take part in it",
    """\
examples:
  pmwvc view                       a session that runs here, also one started by ros2 launch
  pmwvc view live                  simulated in real time, without ROS; take hold in the browser
  pmwvc view sessions/20260101T120000Z-carry_16ms
                                   a recorded session, with a time line

The page is for this machine only. --host 0.0.0.0 opens it to the network; the token in the printed
address is needed to connect.
""",
    cli.argument("what", nargs="?", metavar="WHAT", help=WHAT, completer=_sessions),
    *(cli.USERS, cli.settings()),
    cli.argument("--namespace", default="", help="namespace of the running session"),
    *cli.PAGE,
)
def view(arguments: argparse.Namespace) -> cli.Result:
    """Serve the page until interrupted."""
    from pmwvc_bringup.session.page import join, serve
    from pmwvc_bringup.session.plan import Page
    from pmwvc_bringup.session.surroundings import require_ros

    page, browser = Page(arguments.host, arguments.port), arguments.browser
    if arguments.what is not None:
        serve(_session(arguments), terminal(), page=page, browser=browser)
        return cli.Result()
    require_ros()
    if arguments.users or arguments.settings:
        raise PmwvcError("--users and --set belong to a scenario: name one, or a session folder")
    return cli.Result(join(terminal(), page=page, namespace=arguments.namespace, browser=browser))


def _session(arguments: argparse.Namespace) -> "Session":
    """Return the session that was recorded in a folder, or one to simulate."""
    from pmwvc_view import SNAPSHOT_S

    folder = Path(arguments.what).expanduser()
    if not folder.is_dir():
        from pmwvc_bringup.session.surroundings import check
        from pmwvc_view.simulated import SimulatedSession

        scenario = cli.scenario_of(arguments)
        check(scenario)
        return SimulatedSession(scenario, snapshot_s=SNAPSHOT_S)
    from pmwvc_analysis.recording.reader import read_scenario, read_session
    from pmwvc_analysis.verdicts.verdicts import summary
    from pmwvc_view.recorded import RecordedSession

    traces, recorded = read_session(folder), read_scenario(folder)
    if recorded is None:
        raise RecordingError(f"{folder} has no scenario.yaml: its users are not known")
    return RecordedSession(traces, recorded, summary(traces, recorded), snapshot_s=SNAPSHOT_S)


WIDTH, INDENT = 99, " " * 6
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
    """Become one node: same process, so that signals and exit code are the node's own. With
    ``--help``, print its parameters instead.
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
                    about = textwrap.wrap("; ".join(filter(None, words)), WIDTH - len(INDENT))
                    lines += [f"{INDENT}{line}" for line in about]
        finally:
            node.destroy_node()
    finally:
        rclpy.shutdown(context=context)
    head = [
        f"usage: pmwvc node {kind} [--ros-args [-r FROM:=TO] [-p NAME:=VALUE] [--params-file F]]",
        f"\nexample:\n  pmwvc node {kind} --ros-args {ROS_ARGUMENTS[kind]}",
        "\nparameters (default; unit and range; description):",
    ]
    text = f"  {ONE_USER}NAME sets a parameter listed above for one user, where users may differ"
    several = any(name.startswith(ONE_USER) for name in names)
    return "\n".join([*head, *lines, *([text] if several else [])])


def _declarations() -> "dict[str, Callable[[Node], object]]":
    """Return, by kind of node, the function that declares its parameters."""
    from pmwvc_analysis import recorder_node
    from pmwvc_master import settings as master
    from pmwvc_netem import settings as netem
    from pmwvc_server import settings as server
    from pmwvc_view import node as view_node

    def recorder(node: "Node") -> None:
        with contextlib.suppress(ParameterError):  # no folder is given; all is declared before
            recorder_node.declare_settings(node)

    def ignore(*_: object) -> None:
        """Take a change of parameters and do nothing: none is made here."""

    return {
        "master": lambda node: master.declare_settings(node, ignore, ignore),
        "server": lambda node: server.declare_settings(node, *[ignore] * 4),
        "netem": lambda node: netem.Settings(node, ignore),
        "recorder": recorder,
        "view": view_node.declare_settings,
    }
