# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc run``: a live session of ROS 2 nodes, and its report."""

import argparse
import sys
from collections.abc import Mapping
from typing import Any

from pmwvc_bringup.command import Command, Result, argument
from pmwvc_bringup.options import PAGE, SESSION
from pmwvc_bringup.output import terminal
from pmwvc_bringup.session import preflight
from pmwvc_bringup.session.plan import Page
from pmwvc_bringup.session.surroundings import new_folder
from pmwvc_bringup.session.terminal import announce, finish, prepared
from pmwvc_core.errors import PmwvcError
from pmwvc_core.scenario.scenario import Scenario

EXAMPLES = """\
examples:
  pmwvc {0} carry_16ms
  pmwvc {0} carry_16ms --duration 5 --set link.delay_s=0.05 --set user2.link.up.loss=0.1
  pmwvc {0} my_scenario.yaml --users 3 --out /tmp/three --json

--set takes any name that 'pmwvc scenarios NAME' prints; the prefix 'user2.' sets that user only.
"""
VIEWED = (
    "\npmwvc run live --view serves the session's page as well, to take part in the browser.\n"
)


def run(arguments: argparse.Namespace) -> Result:
    """Run a live session; 1 when a node did not come up, 130 when ended before it began."""
    preflight.require_ros()
    if arguments.view:
        from pmwvc_bringup.session.page import require_address

        require_address(arguments.host, arguments.port)
    scenario, folder = prepared(arguments)
    from pmwvc_bringup.session.runner import LiveSession, StartError

    console = terminal()
    page = Page(arguments.host, arguments.port) if arguments.view else None
    browser = not arguments.no_browser
    recorded = []
    try:
        while True:
            announce(console, scenario, folder, live=True)
            session = LiveSession(scenario, folder, console=console, page=page, browser=browser)
            if session.run():
                recorded.append((folder, scenario))
            elif not recorded:
                print("pmwvc: ended before the session began", file=sys.stderr)
                return Result(130)
            if session.restart is None:
                break
            scenario = begun_again(scenario, session.restart)
            folder, page = new_folder(scenario.name, None), session.page
    except StartError as error:
        print(f"pmwvc: {error}", file=sys.stderr)
        return Result(1)
    results = [finish(console, *each, check=arguments.check) for each in recorded]
    return Result(max(result.code for result in results), results[-1].document)


def begun_again(scenario: Scenario, settings: Mapping[str, Any]) -> Scenario:
    """Return the scenario that a page begins again; settings refused to a page change nothing."""
    from pmwvc_view.controls import changed

    try:
        return changed(scenario, settings)
    except PmwvcError as error:
        print(f"pmwvc: {error}", file=sys.stderr)
        return scenario


COMMAND = Command(
    name="run",
    help="run a live session of ROS 2 nodes and write its report",
    examples=EXAMPLES.format("run") + VIEWED,
    arguments=(
        *SESSION,
        argument("--view", action="store_true", help="serve the session's page and open it"),
        *PAGE,
    ),
    run=run,
)
