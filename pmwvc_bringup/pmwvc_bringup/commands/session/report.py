# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc report``: a recorded session, or those of a comparison, judged and drawn anew."""

import argparse
from pathlib import Path

from pmwvc_bringup.command import Command, Result
from pmwvc_bringup.options import CHECK, FOLDER, json_document, out
from pmwvc_bringup.output import terminal
from pmwvc_bringup.session.terminal import finish
from pmwvc_core.errors import PmwvcError

EXAMPLES = """\
examples:
  pmwvc report sessions/20260101T120000Z-carry_16ms
  pmwvc report sessions/20260101T120000Z-carry_16ms --json
  pmwvc report sessions/20260101T120000Z-carry_16ms --out /tmp/elsewhere
"""


def run(arguments: argparse.Namespace) -> Result:
    """Judge the recording and write its report."""
    from pmwvc_analysis.compare.files import is_comparison

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


COMMAND = Command(
    name="report",
    help="rewrite the report of a recorded session",
    examples=EXAMPLES,
    arguments=(
        FOLDER,
        CHECK,
        out("where to write it (default: the session folder)"),
        json_document("print summary.json on stdout and nothing else"),
    ),
    run=run,
)
