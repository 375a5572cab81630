# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Commands around a session: the machine, its shell, scenarios, access."""

import argparse
import sys
import textwrap
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING

from pmwvc_bringup.command import Result, argument, command
from pmwvc_bringup.options import json_document, scenario_names, session_folders
from pmwvc_core.errors import PmwvcError

if TYPE_CHECKING:
    from pmwvc_analysis.doctor import Finding as RecordingFinding
    from pmwvc_bringup.machine import Finding


@command(
    "doctor",
    "check this machine or a recorded session",
    """\
examples:
  pmwvc doctor                                 this machine
  pmwvc doctor sessions/20260101T120000Z-carry_16ms    a recorded session
  pmwvc doctor sessions/20260101T120000Z-carry_16ms --mend mended    a file that was cut

exit code: 1 when the machine has a problem; a recording gives 0 when it is complete, 2 when it has
only losses that it declares, 3 when it is damaged
""",
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
)
def doctor(arguments: argparse.Namespace) -> Result:
    """Examine the machine or a recording."""
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
        from pmwvc_analysis.recording.salvage import mend

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


WIDTH = 99
LISTED = ("name", "description", "controller", "users", "dof", "duration_s")


@command(
    "scenarios",
    "list the scenarios, or print one",
    """\
examples:
  pmwvc scenarios                              names and descriptions
  pmwvc scenarios carry_16ms                   every parameter of one, as YAML
  pmwvc scenarios carry_16ms > my.yaml         the start of one of your own
  pmwvc scenarios --json                       the list for a program
""",
    argument(
        "name",
        nargs="?",
        metavar="NAME",
        help="name, or a YAML file",
        completer=scenario_names,
    ),
    json_document(),
)
def scenarios(arguments: argparse.Namespace) -> Result:
    """Print the list, or one scenario as YAML."""
    from pmwvc_bringup import scenarios as files
    from pmwvc_core.network.presets import PRESETS

    if arguments.name:
        scenario = files.load(arguments.name)
        sys.stdout.write(files.to_yaml(scenario))
        return Result(document=scenario.to_dict())
    known = [files.load(name).flat() for name in files.known()]
    entries = [(values["name"], values["description"]) for values in known]
    networks = "for --set link.preset=NAME: " + ", ".join(PRESETS) + "."
    for name, text in [*entries, ("", ""), ("networks", networks)]:
        head = f"{name:24} "
        print(textwrap.fill(text, WIDTH, initial_indent=head, subsequent_indent=" " * len(head)))
    listed = [{name: values[name] for name in LISTED} for values in known]
    return Result(document={"scenarios": listed, "networks": list(PRESETS)})


@command(
    "token",
    "make the session tokens of a server and its users",
    """\
examples:
  pmwvc token keys user1 user2                 keys/server for the server, keys/user1, keys/user2
  pmwvc node server --ros-args -p session.token_file:=keys/server
  pmwvc node master --ros-args -r __ns:=/user1 -p session.token_file:=keys/user1
""",
    argument("folder", help="for the files, new or without them"),
    argument("users", nargs="+", metavar="USER", help="name of a user (its namespace)"),
)
def token(arguments: argparse.Namespace) -> Result:
    """Write the files; none of them may be there."""
    from pmwvc_core.runtime.token_files import write_session

    for path in write_session(Path(arguments.folder).expanduser(), arguments.users):
        print(path)
    return Result()


SHELLS = ("bash", "zsh", "fish")
PROGRAMS = ["pmwvc", "./pmwvc"]


@command(
    "completion",
    "print the completion script for a shell",
    """\
examples:
  eval "$(./pmwvc completion)"                 this bash
  ./pmwvc completion zsh >> ~/.zshrc           every zsh from now on
""",
    argument("shell", nargs="?", choices=SHELLS, default="bash", help="bash by default"),
)
def completion(arguments: argparse.Namespace) -> Result:
    """Print the script."""
    from argcomplete.shell_integration import shellcode

    print(shellcode(PROGRAMS, shell=arguments.shell))
    return Result()
