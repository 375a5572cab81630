# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The command line ``pmwvc``: its parser, built from the records of the commands; one command is
parsed and run, and its result becomes the exit code.

Exit code 0: done; 1: a session could not start, the machine has a problem, or ``--check`` found
that a session was not stable, not passive, interrupted, disturbed or not recorded whole; 2: a
mistake of the user, named in one message on stderr; 130: interrupted. (``doctor`` of a recording:
see there.) The commands: :mod:`pmwvc_bringup.commands`.
"""

import argparse
import contextlib
import importlib
import os
import pkgutil
import re
import sys
from collections.abc import Sequence
from functools import partial
from importlib import metadata
from typing import Any, NoReturn

from pmwvc_bringup import commands
from pmwvc_bringup.command import Command, Result
from pmwvc_bringup.output import document
from pmwvc_core.errors import PmwvcError

EXAMPLES = """\
examples:
  pmwvc doctor                 check whether this machine can run a session
  pmwvc scenarios              list the scenarios
  pmwvc run carry_16ms         a live session: ROS 2 nodes, 1 kHz force loops, a report
  pmwvc simulate carry_16ms    the same in virtual time, without ROS
"""


# Examples stay as written.
HELP = partial(argparse.RawDescriptionHelpFormatter, max_help_position=28, width=99)


class Parser(argparse.ArgumentParser):
    """An argument parser whose refusals are one message."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options, formatter_class=HELP, allow_abbrev=False)

    def error(self, message: str) -> NoReturn:
        """Print one message and exit with 2."""
        if re.match(r"unrecognized arguments: \w\S*=", message):
            message += ": each NAME=VALUE needs a --set (or --over) of its own"
        self.exit(2, f"{self.prog}: {message} (see '{self.prog} --help')\n")


def _version() -> str:
    """Return the version of the wheel without ROS, or of a workspace."""
    for distribution in ("pmwvc_bringup", "pmwvc"):
        with contextlib.suppress(metadata.PackageNotFoundError):
            return metadata.version(distribution)
    return "of an environment that was not built"


def library() -> list[Command]:
    """Return every command, by name."""
    records = [
        value
        for found in pkgutil.walk_packages(commands.__path__, f"{commands.__name__}.")
        for value in vars(importlib.import_module(found.name)).values()
        if isinstance(value, Command)
    ]
    return sorted(records, key=lambda one: one.name)


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of the whole command line."""
    what = "Networked cooperative haptics by passive multirate wave-variable control."
    parser = Parser(prog="pmwvc", description=what, epilog=EXAMPLES)
    parser.add_argument("--version", action="version", version=f"pmwvc {_version()}")
    several = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for command in library():
        add = partial(several.add_parser, help=command.help, description=f"{command.help}.")
        nested = add(command.name, epilog=command.examples)
        nested.set_defaults(command=command)
        for name, text, options in command.arguments:
            nested.add_argument(name, help=text, **options)
    return parser


def main(words: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code."""
    arguments = build_parser().parse_args(words)
    try:
        with document(wanted=getattr(arguments, "json", False)) as write:
            result: Result = arguments.command.run(arguments)
            write(result.document)
        sys.stdout.flush()
        return result.code
    except PmwvcError as error:
        print(f"pmwvc: {error}", file=sys.stderr)
        return 2
    except BrokenPipeError:  # the reader of the output has gone
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except KeyboardInterrupt:
        print("pmwvc: interrupted", file=sys.stderr)
        return 130
