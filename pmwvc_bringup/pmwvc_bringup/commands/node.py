# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Commands for live sessions: ``pmwvc view``, a session in the browser, also one that was recorded
or is simulated in real time; and ``pmwvc node``, one node by itself.
"""

import argparse
import os
import signal
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from pmwvc_bringup import command as cli
from pmwvc_bringup.output import terminal
from pmwvc_core.errors import PmwvcError, RecordingError

if TYPE_CHECKING:
    from pmwvc_view.session import Session

WHAT = "a session folder, or a scenario to simulate in real time (nothing: a session that runs)"
NODES = ("master", "netem", "recorder", "server", "view")


@cli.command(
    cli.argument("what", WHAT, nargs="?", metavar="WHAT"),
    *(cli.USERS, cli.SET),
    cli.argument("--namespace", "namespace of the running session", default=""),
    *cli.PAGE,
)
def view(arguments: argparse.Namespace) -> cli.Result:
    """Show a session in the browser and take part in it.

    examples:
      pmwvc view                       a session that runs here, also one started by ros2 launch
      pmwvc view live                  simulated in real time, without ROS; act in the browser
      pmwvc view sessions/20260101T120000Z-carry_16ms
                                       a recorded session, with a time line

    The page is for this machine only. --host 0.0.0.0 opens it to the network; the token in the
    printed address is needed to connect.
    """
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


@cli.command(
    cli.argument("kind", "which node", choices=NODES),
    cli.argument("arguments", "passed on to the node", nargs=argparse.REMAINDER),
)
def node(arguments: argparse.Namespace) -> cli.Result:
    """Run one node by itself.

    examples:
      pmwvc node server --ros-args -p users:="[user1, user2]"
      pmwvc node master --ros-args -r __ns:=/user1 --params-file user1.yaml
      pmwvc node netem --ros-args -p users:="[user1, user2]" -p preset:=lte
      pmwvc node recorder --ros-args -p users:="[user1, user2]" -p folder:=my_session

    Parameters: docs/parameters.md; of a node that runs: ros2 param describe NODE NAME.
    """
    from pmwvc_bringup.session.plan import MODULES
    from pmwvc_bringup.session.surroundings import LOCALHOST, RANGE, own_environment, require_ros

    require_ros()
    words = [sys.executable, "-m", MODULES[arguments.kind], *arguments.arguments]
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})  # until the node can end by it
    os.execve(sys.executable, words, own_environment({RANGE: LOCALHOST, **os.environ}))
