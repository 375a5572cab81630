# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Commands that run a session, live or in virtual time, or work on a recorded one."""

import argparse
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pmwvc_bringup.command import Result, argument, command
from pmwvc_bringup.options import CHECK, FOLDER, PAGE, SESSION, json_document, out
from pmwvc_bringup.output import terminal
from pmwvc_bringup.progress import doing
from pmwvc_core.errors import PmwvcError

if TYPE_CHECKING:
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


@command(
    "run",
    "run a live session of ROS 2 nodes and write its report",
    EXAMPLES.format("run") + VIEWED,
    *SESSION,
    argument("--view", action="store_true", help="serve the session's page and open it"),
    *PAGE,
)
def run(arguments: argparse.Namespace) -> Result:
    """Run a live session; 1 when a node did not come up, 130 when ended before it began."""
    from pmwvc_bringup.session.plan import Page
    from pmwvc_bringup.session.preflight import require_ros
    from pmwvc_bringup.session.surroundings import new_folder
    from pmwvc_bringup.session.terminal import announce, finish, prepared

    require_ros()
    if arguments.view and arguments.no_figures:
        raise PmwvcError("--view names the report on the page: leave out --no-figures")
    page = Page(arguments.host, arguments.port) if arguments.view else None
    if page is not None:
        from pmwvc_bringup.session.page import require_address

        require_address(page)
    scenario, folder = prepared(arguments)
    from pmwvc_bringup.session.runner import LiveSession, StartError

    console = terminal()
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
    figures = not arguments.no_figures
    results = [finish(console, *each, check=arguments.check, figures=figures) for each in recorded]
    return Result(max(result.code for result in results), results[-1].document)


def begun_again(scenario: "Scenario", settings: Mapping[str, Any]) -> "Scenario":
    """Return the scenario that a page begins again; settings refused to a page change nothing."""
    from pmwvc_view.controls import changed

    try:
        return changed(scenario, settings)
    except PmwvcError as error:
        print(f"pmwvc: {error}", file=sys.stderr)
        return scenario


@command(
    "simulate",
    "run a session in virtual time, without ROS, with the same report",
    EXAMPLES.format("simulate"),
    *SESSION,
)
def simulate_(arguments: argparse.Namespace) -> Result:
    """Simulate, record and report."""
    from pmwvc_bringup.session.terminal import announce, finish, prepared

    scenario, folder = prepared(arguments)
    from pmwvc_analysis.events.events import faults, kept
    from pmwvc_analysis.recording.from_traces import record_traces
    from pmwvc_core.simulation.session import simulate

    console = terminal()
    announce(console, scenario, folder, live=False)
    with doing("simulating") as work:
        (traces,) = simulate([scenario], progress=work)
    for fault in faults(traces):
        console.print(f"  Warning: {fault['who']}: {fault['what']}", markup=False)
    with doing("writing the recording"):
        record_traces(folder, traces, scenario, metadata=kept(traces))
    figures = not arguments.no_figures
    return finish(console, folder, scenario, check=arguments.check, figures=figures)


@command(
    "report",
    "rewrite the report of a recorded session",
    """\
examples:
  pmwvc report sessions/20260101T120000Z-carry_16ms
  pmwvc report sessions/20260101T120000Z-carry_16ms --json
  pmwvc report sessions/20260101T120000Z-carry_16ms --out /tmp/elsewhere
""",
    FOLDER,
    CHECK,
    out("where to write it (default: the session folder)"),
    json_document("print summary.json on stdout and nothing else"),
)
def report(arguments: argparse.Namespace) -> Result:
    """Judge the recording and write its report."""
    from pmwvc_analysis.compare.files import is_comparison
    from pmwvc_bringup.session.terminal import finish

    folder = Path(arguments.folder)
    if is_comparison(folder):
        from pmwvc_bringup.comparison.report import again

        if arguments.check:
            raise PmwvcError(f"--check judges one session: name a folder in {folder / 'runs'}")
        if arguments.out:
            raise PmwvcError(f"{folder} is a comparison: its report is written into it, not --out")
        return again(folder, terminal())
    target = Path(arguments.out).expanduser() if arguments.out else None
    return finish(terminal(), folder, None, check=arguments.check, out=target)


TARGETS = {"csv": "csv", "mat": "session.mat", "hdf5": "session.h5"}


@command(
    "export",
    "write the signals of a recorded session as CSV, MAT or HDF5",
    """\
examples:
  pmwvc export sessions/20260101T120000Z-carry_16ms                 a folder of CSV files
  pmwvc export sessions/20260101T120000Z-carry_16ms --as mat        for MATLAB and Octave
  pmwvc export sessions/20260101T120000Z-carry_16ms --as hdf5 --out /tmp/carry.h5
""",
    FOLDER,
    argument(
        "--as",
        dest="kind",
        choices=tuple(TARGETS),
        default="csv",
        help="what to write (default: csv)",
    ),
    out("file, or folder of CSV files (default: in the session folder)", metavar="PATH"),
)
def export_(arguments: argparse.Namespace) -> Result:
    """Read the recording and write the files."""
    from pmwvc_analysis.export import export
    from pmwvc_analysis.recording.reader import read_scenario, read_session

    folder = Path(arguments.folder)
    target = Path(arguments.out) if arguments.out else folder / TARGETS[arguments.kind]
    export(target.expanduser(), read_session(folder), read_scenario(folder), kind=arguments.kind)
    print(target)
    return Result()
