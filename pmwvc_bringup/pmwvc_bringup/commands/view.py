# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc view``: a session in the browser: one that runs, one that was recorded, or one that is
simulated in real time.
"""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from pmwvc_bringup import command as cli
from pmwvc_bringup.output import terminal
from pmwvc_core.errors import PmwvcError, RecordingError

if TYPE_CHECKING:
    from pmwvc_view.session import Session


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
    cli.argument(
        "what",
        nargs="?",
        metavar="WHAT",
        help="a session folder, or a scenario to simulate in real time (nothing: a session "
        "that runs)",
        completer=_sessions,
    ),
    cli.USERS,
    cli.settings(),
    cli.argument("--namespace", default="", help="namespace of the running session"),
    *cli.PAGE,
)
def view(arguments: argparse.Namespace) -> cli.Result:
    """Serve the page until interrupted."""
    from pmwvc_bringup.session.page import join, serve
    from pmwvc_bringup.session.plan import Page
    from pmwvc_bringup.session.surroundings import require_ros

    page, browser = Page(arguments.host, arguments.port), not arguments.no_browser
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
    from pmwvc_view.recorded.session import RecordedSession

    traces, recorded = read_session(folder), read_scenario(folder)
    if recorded is None:
        raise RecordingError(f"{folder} has no scenario.yaml: its users are not known")
    return RecordedSession(traces, recorded, summary(traces, recorded), snapshot_s=SNAPSHOT_S)
