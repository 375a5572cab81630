# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc simulate``: a session in virtual time, without ROS, with the same report."""

import argparse

from pmwvc_bringup.command import Command, Result
from pmwvc_bringup.commands.session.run import EXAMPLES
from pmwvc_bringup.options import SESSION
from pmwvc_bringup.output import terminal
from pmwvc_bringup.progress import doing
from pmwvc_bringup.session.terminal import announce, finish, prepared


def run(arguments: argparse.Namespace) -> Result:
    """Simulate, record and report."""
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
    return finish(console, folder, scenario, check=arguments.check)


COMMAND = Command(
    name="simulate",
    help="run a session in virtual time, without ROS, with the same report",
    examples=EXAMPLES.format("simulate"),
    arguments=SESSION,
    run=run,
)
