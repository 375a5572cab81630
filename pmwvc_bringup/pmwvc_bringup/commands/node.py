# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc view``, a session in the browser that was recorded or is simulated in real time; and
``pmwvc node``, one node by itself.
"""

import argparse
import os
import signal
import sys
from pathlib import Path

from pmwvc_bringup import command as cli
from pmwvc_bringup.output import terminal
from pmwvc_core.errors import PmwvcError

WHAT = "a session folder, or a scenario to simulate in real time"
NODES = ("master", "netem", "recorder", "server", "view")


@cli.command(cli.argument("what", WHAT, metavar="WHAT"), cli.USERS, cli.SET, *cli.PAGE)
def view(arguments: argparse.Namespace) -> cli.Result:
    """Show a session in the browser and take part in it.

    examples:
      pmwvc view live                  simulated in real time, without ROS; act in the browser
      pmwvc view sessions/20260101T120000Z-carry_16ms
                                       a recorded session, with a time line

    A session of nodes: pmwvc run --view, or pmwvc node view in its ROS domain.

    The page is for this machine only. --host 0.0.0.0 opens it to the network; the token in the
    printed address is needed to connect.
    """
    from pmwvc_bringup.session.page import serve, show
    from pmwvc_bringup.session.plan import Page

    page, browser = Page(arguments.host, arguments.port), arguments.browser
    folder = Path(arguments.what).expanduser()
    if folder.is_dir():
        from pmwvc_analysis.session_files import REPLAY

        if not (file := folder / REPLAY).is_file():
            raise PmwvcError(f"{folder} has no {REPLAY}: 'pmwvc report {folder}' writes it")
        show(file.resolve().as_uri(), terminal(), browser=browser)
        return cli.Result()
    from pmwvc_bringup.session.surroundings import check
    from pmwvc_view.simulated import SimulatedSession

    scenario = cli.scenario_of(arguments)
    check(scenario)
    serve(SimulatedSession(scenario), terminal(), page=page, browser=browser)
    return cli.Result()


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
