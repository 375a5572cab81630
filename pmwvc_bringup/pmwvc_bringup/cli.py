# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The command line ``pmwvc``: options and help. What the commands do is in
:mod:`pmwvc_bringup.commands`.

Exit code 0: done; 1: a session could not start, the machine has a problem, or ``--check`` found
that a session was not stable, not passive, interrupted, disturbed or not recorded whole; 2: a
mistake of the user, said in one message on stderr; 130: interrupted. (``doctor`` of a recording:
see there.)
"""

import argparse
import difflib
import importlib.metadata
import os
import re
import sys
from collections.abc import Sequence
from typing import Any, NoReturn

from pmwvc_bringup import (
    commands,
    compare_command,
    completion,
    filter_command,
    map_command,
    replay_command,
    stability_command,
    transparency_command,
    tune_command,
)
from pmwvc_bringup.options import add_check, add_json, add_scenario, add_settings
from pmwvc_core.errors import PmwvcError

MAIN_EXAMPLES = """\
examples:
  pmwvc doctor                 check whether this machine can run a session
  pmwvc scenarios              list the scenarios
  pmwvc run carry_16ms         a live session: ROS 2 nodes, 1 kHz force loops, a report
  pmwvc simulate carry_16ms    the same in virtual time, without ROS
"""
SESSION_EXAMPLES = """\
examples:
  pmwvc {0} carry_16ms
  pmwvc {0} carry_16ms --duration 5 --set link.delay_s=0.05 --set user2.link.up.loss=0.1
  pmwvc {0} my_scenario.yaml --users 3 --out /tmp/three --json

--set takes any name that 'pmwvc scenarios NAME' prints; the prefix 'user2.' sets that user only.
"""
REPORT_EXAMPLES = """\
examples:
  pmwvc report sessions/20260101T120000Z-carry_16ms
  pmwvc report sessions/20260101T120000Z-carry_16ms --json
  pmwvc report sessions/20260101T120000Z-carry_16ms --out /tmp/elsewhere
"""
NODE_EXAMPLES = """\
examples:
  pmwvc node server --ros-args -p users:="[user1, user2]"
  pmwvc node master --ros-args -r __ns:=/user1 --params-file user1.yaml
  pmwvc node master --help                     every parameter of a node
"""
SCENARIOS_EXAMPLES = """\
examples:
  pmwvc scenarios                              names and descriptions
  pmwvc scenarios carry_16ms                   every parameter of one, as YAML
  pmwvc scenarios carry_16ms > my.yaml         the start of one of your own
  pmwvc scenarios --json                       the list for a program
"""
DOCTOR_EXAMPLES = """\
examples:
  pmwvc doctor                                 this machine
  pmwvc doctor sessions/20260101T120000Z-carry_16ms    a recorded session
  pmwvc doctor sessions/20260101T120000Z-carry_16ms --mend mended    a file that was cut

exit code: 1 when the machine has a problem; a recording gives 0 when it is complete, 2 when it is
but for losses it declares, 3 when it is damaged
"""


class _HelpFormatter(argparse.RawDescriptionHelpFormatter):
    """Examples stay as written; the longest name fits before its description."""

    def __init__(self, prog: str) -> None:
        super().__init__(prog, max_help_position=28, width=99)

    def add_argument(self, action: argparse.Action) -> None:
        """Count the indentation of sub-commands, which the base class forgets."""
        super().add_argument(action)
        if isinstance(action, argparse._SubParsersAction):
            self._action_max_length += self._indent_increment


class Parser(argparse.ArgumentParser):
    """An argument parser whose refusals name the nearest right word."""

    def __init__(self, **options: Any) -> None:
        options.setdefault("formatter_class", _HelpFormatter)
        super().__init__(**{**options, "allow_abbrev": False})

    def error(self, message: str) -> NoReturn:
        """Print one message and exit with 2."""
        choice = re.search(r"invalid choice: '(.*?)' \(choose from (.*)\)", message)
        options = re.match(r"unrecognized arguments: (\S+)", message)
        word, known, owners = "", [], []
        if choice:
            word, known = choice[1], re.findall(r"[\w-]+", choice[2])
        elif options:
            word, known = options[1].partition("=")[0], sorted(_options_of(self))
            owners = _commands_with(self, word)
        near = difflib.get_close_matches(word, known, n=1, cutoff=0.5)
        hint = f"; did you mean {near[0]}?" if near else ""
        if owners:
            hint = f"; {word} is an option of {', '.join(owners)} only"
        self.exit(2, f"{self.prog}: {message}{hint} (see '{self.prog} --help')\n")


def _options_of(parser: argparse.ArgumentParser) -> set[str]:
    """Return the long options of a parser and its sub-commands."""
    found: set[str] = set()
    for action in parser._actions:
        found.update(option for option in action.option_strings if option.startswith("--"))
        if isinstance(action, argparse._SubParsersAction):
            for nested in action.choices.values():
                found |= _options_of(nested)
    return found


def _commands_with(parser: argparse.ArgumentParser, option: str) -> list[str]:
    """Return the sub-commands of a parser that have an option."""
    return [
        name
        for action in parser._actions
        if isinstance(action, argparse._SubParsersAction)
        for name, nested in action.choices.items()
        if option in _options_of(nested)
    ]


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of the whole command line."""
    parser = Parser(
        prog="pmwvc",
        description="Networked cooperative haptics by passive multirate wave-variable control.",
        epilog=MAIN_EXAMPLES,
    )
    parser.add_argument("--version", action="version", version=f"pmwvc {_version()}")
    several = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)

    def command(name: str, text: str, examples: str) -> argparse.ArgumentParser:
        nested = several.add_parser(name, help=text, description=f"{text}.", epilog=examples)
        nested.set_defaults(command=getattr(commands, name))
        return nested

    for name, text in (
        ("run", "run a live session of ROS 2 nodes and write its report"),
        ("simulate", "run a session in virtual time, without ROS, with the same report"),
    ):
        _add_session_options(command(name, text, SESSION_EXAMPLES.format(name)))

    report = command("report", "rewrite the report of a recorded session", REPORT_EXAMPLES)
    report.add_argument("folder", metavar="FOLDER", help="a session folder")
    add_check(report)
    report.add_argument(
        "--out", metavar="FOLDER", help="where to write it (default: the session folder)"
    )
    add_json(report, "print summary.json on stdout and nothing else")

    replay_command.add(several)
    compare_command.add(several)
    stability_command.add(several)
    map_command.add(several)
    transparency_command.add(several)
    tune_command.add(several)
    filter_command.add(several)

    node = command("node", "run one node by itself", NODE_EXAMPLES)
    node.add_argument("kind", choices=sorted(commands.NODES), help="which node")
    node.add_argument("arguments", nargs=argparse.REMAINDER, help="passed on to the node")

    scenarios = command("scenarios", "list the scenarios, or print one", SCENARIOS_EXAMPLES)
    scenarios.add_argument("name", nargs="?", metavar="NAME", help="name, or a YAML file")
    add_json(scenarios)

    doctor = command("doctor", "check this machine or a recorded session", DOCTOR_EXAMPLES)
    doctor.add_argument("folder", nargs="?", metavar="FOLDER", help="a session folder")
    doctor.add_argument(
        "--mend",
        metavar="NEW",
        help="write what is whole of a damaged recording into a new session folder",
    )
    add_json(doctor, "print the findings as JSON on stdout")

    completion.add(several)
    return parser


def _add_session_options(parser: argparse.ArgumentParser) -> None:
    add_scenario(parser)
    parser.add_argument("--duration", type=float, metavar="S", help="length of the session in s")
    add_settings(parser)
    parser.add_argument(
        "--out",
        metavar="FOLDER",
        help="session folder, new or empty (default: sessions/<UTC time>-<scenario>)",
    )
    add_check(parser)
    add_json(parser, "print summary.json on stdout and nothing else")


def _version() -> str:
    try:
        return importlib.metadata.version("pmwvc_bringup")
    except importlib.metadata.PackageNotFoundError:
        return "of an environment that was not built"


def main(words: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code."""
    parser = build_parser()
    if "_ARGCOMPLETE" in os.environ:  # a shell asks which words could follow
        completion.complete(parser)
    arguments = parser.parse_args(words)
    try:
        code: int = arguments.command(arguments)
        sys.stdout.flush()
        return code
    except PmwvcError as error:
        print(f"pmwvc: {error}", file=sys.stderr)
        return 2
    except BrokenPipeError:  # the reader of our output went away: nothing is left to say
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except KeyboardInterrupt:
        print("pmwvc: interrupted", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
