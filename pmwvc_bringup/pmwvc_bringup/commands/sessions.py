# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Commands that run a session, live or in virtual time, or work on a recorded one."""

import argparse
import sys

from pmwvc_bringup import command as cli
from pmwvc_bringup.output import doing, terminal
from pmwvc_core.errors import PmwvcError


@cli.command(*cli.SESSION, cli.flag("--view", "serve the session's page and open it"), *cli.PAGE)
def run(arguments: argparse.Namespace) -> cli.Result:
    """Run a live session of ROS 2 nodes and write its report.

    examples:
      pmwvc run carry_16ms
      pmwvc run carry_16ms --duration 5 --set link.delay_s=0.05 --set user2.link.up.loss=0.1
      pmwvc run my_scenario.yaml --users 3 --out /tmp/three --json

    --set takes any name that 'pmwvc scenarios NAME' prints; the prefix 'user2.' sets that user
    only.

    pmwvc run live --view serves the session's page as well, to take part in the browser.
    """
    from pmwvc_bringup.session.plan import Page
    from pmwvc_bringup.session.surroundings import require_ros
    from pmwvc_bringup.session.terminal import announce, finish, prepared

    require_ros()
    if arguments.view and not arguments.figures:
        raise PmwvcError("--view names the report on the page: leave out --no-figures")
    page = Page(arguments.host, arguments.port) if arguments.view else None
    if page is not None:
        from pmwvc_bringup.session.page import require_address

        require_address(page)
    scenario, folder = prepared(arguments)
    from pmwvc_bringup.session.runner import NodeSession, StartError

    console = terminal()
    try:
        announce(console, scenario, folder, live=True)
        browser = arguments.browser
        begun = NodeSession(scenario, folder, console=console, page=page, browser=browser).run()
    except StartError as error:
        print(f"pmwvc: {error}", file=sys.stderr)
        return cli.Result(1)
    if not begun:
        print("pmwvc: ended before the session began", file=sys.stderr)
        return cli.Result(130)
    figures, check = arguments.figures, arguments.check
    return finish(console, folder, scenario, check=check, figures=figures)


@cli.command(*cli.SESSION)
def simulate_(arguments: argparse.Namespace) -> cli.Result:
    """Run a session in virtual time, without ROS, with the same report.

    examples:
      pmwvc simulate carry_16ms
      pmwvc simulate carry_16ms --duration 5 --set link.delay_s=0.05 --set user2.link.up.loss=0.1
      pmwvc simulate my_scenario.yaml --users 3 --out /tmp/three --json

    --set takes any name that 'pmwvc scenarios NAME' prints; the prefix 'user2.' sets that user
    only.
    """
    from pmwvc_bringup.session.terminal import announce, finish, prepared

    scenario, folder = prepared(arguments)
    from pmwvc_analysis.events.events import faults
    from pmwvc_analysis.recording.from_traces import record_traces
    from pmwvc_core.simulation.session import simulate_one

    console = terminal()
    announce(console, scenario, folder, live=False)
    with doing("simulating") as work:
        traces = simulate_one(scenario, progress=work)
    for fault in faults(traces):
        console.print(f"  Warning: {fault['who']}: {fault['what']}", markup=False)
    with doing("writing the recording"):
        record_traces(folder, traces, scenario)
    figures, check = arguments.figures, arguments.check
    return finish(console, folder, scenario, check=check, figures=figures)


WHERE = cli.OUT.but("where to write it (default: the session folder)")


@cli.command(cli.FOLDER, cli.CHECK, WHERE, cli.SUMMARY)
def report(arguments: argparse.Namespace) -> cli.Result:
    """Rewrite the report of a recorded session.

    examples:
      pmwvc report sessions/20260101T120000Z-carry_16ms
      pmwvc report sessions/20260101T120000Z-carry_16ms --json
      pmwvc report sessions/20260101T120000Z-carry_16ms --out /tmp/elsewhere
    """
    from pmwvc_bringup.session.terminal import finish

    return finish(terminal(), arguments.folder, None, check=arguments.check, out=arguments.out)


TARGETS = {"csv": "csv", "mat": "session.mat"}


AS = "what to write (default: csv)"


@cli.command(
    cli.FOLDER, cli.argument("--as", AS, dest="kind", choices=(*TARGETS,), default="csv"),
    cli.OUT.but("file, or folder of CSV files (default: in the session folder)", metavar="PATH"),
)  # fmt: skip
def export_(arguments: argparse.Namespace) -> cli.Result:
    """Write the signals of a recorded session as CSV or MAT.

    examples:
      pmwvc export sessions/20260101T120000Z-carry_16ms                 a folder of CSV files
      pmwvc export sessions/20260101T120000Z-carry_16ms --as mat        for MATLAB and Octave
    """
    from pmwvc_analysis.export import export
    from pmwvc_analysis.recording.reader import read_scenario, read_session

    folder = arguments.folder
    target = arguments.out or folder / TARGETS[arguments.kind]
    export(target, read_session(folder), read_scenario(folder), kind=arguments.kind)
    print(target)
    return cli.Result()
