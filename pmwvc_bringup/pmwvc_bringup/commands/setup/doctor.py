# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc doctor``: findings about this machine, or about a recorded session."""

import argparse
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING

from pmwvc_bringup.command import Command, Result, argument
from pmwvc_bringup.options import json_document, session_folders
from pmwvc_core.errors import PmwvcError

if TYPE_CHECKING:
    from pmwvc_analysis.doctor import Finding as RecordingFinding
    from pmwvc_bringup.machine import Finding

EXAMPLES = """\
examples:
  pmwvc doctor                                 this machine
  pmwvc doctor sessions/20260101T120000Z-carry_16ms    a recorded session
  pmwvc doctor sessions/20260101T120000Z-carry_16ms --mend mended    a file that was cut

exit code: 1 when the machine has a problem; a recording gives 0 when it is complete, 2 when it has
only losses that it declares, 3 when it is damaged
"""


def run(arguments: argparse.Namespace) -> Result:
    """Examine the machine (1 when there is a problem) or a recording.

    A recording gives 0 when it is complete, 2 when it has only losses that it declares, 3 when it
    is damaged.
    """
    findings: Sequence[Finding | RecordingFinding]
    if arguments.mend and not arguments.folder:
        raise PmwvcError("--mend: name the damaged session folder as well")
    if arguments.folder:
        from pmwvc_analysis.doctor import exit_code

        recorded = _of_recording(Path(arguments.folder), arguments.mend)
        findings, code = recorded, exit_code(recorded)
    else:
        from pmwvc_bringup.machine import PROBLEM, examine

        findings = examine()
        code = int(any(finding.status == PROBLEM for finding in findings))
    for finding in findings:
        print(finding.line())
    return Result(code, {"exit_code": code, "findings": [asdict(finding) for finding in findings]})


def _of_recording(folder: Path, mend_into: str | None) -> "list[RecordingFinding]":
    """Return the findings about a session, those of a comparison, or the mended copy of one."""
    from pmwvc_analysis.doctor import check_recording

    if mend_into:
        from pmwvc_analysis.recording.recover import mend

        target = Path(mend_into).expanduser()
        print(mend(folder, target))
        return check_recording(target)
    if not folder.exists():
        raise PmwvcError(f"{folder}: there is no such session folder")
    from pmwvc_analysis.compare.files import is_comparison
    from pmwvc_analysis.compare.files import session_folders as sessions_of

    if not is_comparison(folder):
        return check_recording(folder)
    return [
        replace(finding, text=f"{session.name}: {finding.text}")
        for session in sessions_of(folder)
        for finding in check_recording(session)
    ]


COMMAND = Command(
    name="doctor",
    help="check this machine or a recorded session",
    examples=EXAMPLES,
    arguments=(
        argument(
            "folder",
            nargs="?",
            metavar="FOLDER",
            help="a session folder",
            completer=session_folders,
        ),
        argument(
            "--mend",
            metavar="NEW",
            help="write the intact part of a damaged recording into a new session folder",
        ),
        json_document("print the findings as JSON on stdout"),
    ),
    run=run,
)
