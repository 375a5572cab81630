# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc run``: a live session of ROS 2 nodes, and its report."""

import argparse
import sys

from pmwvc_bringup.command import Command, Result
from pmwvc_bringup.options import SESSION
from pmwvc_bringup.output import terminal
from pmwvc_bringup.session import preflight
from pmwvc_bringup.session.terminal import announce, finish, prepared

EXAMPLES = """\
examples:
  pmwvc {0} carry_16ms
  pmwvc {0} carry_16ms --duration 5 --set link.delay_s=0.05 --set user2.link.up.loss=0.1
  pmwvc {0} my_scenario.yaml --users 3 --out /tmp/three --json

--set takes any name that 'pmwvc scenarios NAME' prints; the prefix 'user2.' sets that user only.
"""


def run(arguments: argparse.Namespace) -> Result:
    """Run a live session; 1 when a node did not come up, 130 when ended before it began."""
    preflight.require_ros()
    scenario, folder = prepared(arguments)
    from pmwvc_bringup.session.runner import LiveSession, StartError

    console = terminal()
    announce(console, scenario, folder, live=True)
    try:
        if not LiveSession(scenario, folder, console=console).run():
            print("pmwvc: ended before the session began", file=sys.stderr)
            return Result(130)
    except StartError as error:
        print(f"pmwvc: {error}", file=sys.stderr)
        return Result(1)
    return finish(console, folder, scenario, check=arguments.check)


COMMAND = Command(
    name="run",
    help="run a live session of ROS 2 nodes and write its report",
    examples=EXAMPLES.format("run"),
    arguments=SESSION,
    run=run,
)
