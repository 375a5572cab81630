# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A command as a record: its name, help, examples, arguments and the function behind it; and the
arguments that several commands take, each declared once.

A function in a module below :mod:`pmwvc_bringup.commands` that is decorated with :func:`command`
is a command. Heavy imports stand inside functions: ``pmwvc --help`` has to answer at once.
"""

import argparse
import inspect
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from pmwvc_core.scenario.scenario import Scenario


class Argument(NamedTuple):
    """An argument: its name and help, and further options of ``add_argument``."""

    name: str
    help: str
    options: Mapping[str, Any]

    def but(self, text: str | None = None, *, name: str = "", **options: Any) -> "Argument":
        """Return the same argument with another help, name or other options."""
        text = self.help if text is None else text
        return Argument(name or self.name, text, {**self.options, **options})


def argument(name: str, text: str = "", **options: Any) -> Argument:
    """Return an argument."""
    return Argument(name, text, options)


class Result(NamedTuple):
    """The exit code of a command, and the document that it prints with ``--json``."""

    code: int = 0
    document: object = None  # plain data, or the text of a JSON file


class Command(NamedTuple):
    """One command; ``run`` raises ``PmwvcError`` for a mistake of the user (exit code 2)."""

    name: str
    help: str  # one clause, without a full stop
    examples: str  # printed below the options
    arguments: tuple[Argument, ...]
    run: Callable[[argparse.Namespace], Result]


def command(*arguments: Argument) -> Callable[[Callable[[argparse.Namespace], Result]], Command]:
    """Make a function the command of its name; its docstring is the help."""

    def made(run: Callable[[argparse.Namespace], Result]) -> Command:
        summary, _, rest = inspect.cleandoc(run.__doc__ or "").partition("\n\n")
        text = summary[0].lower() + summary[1:].removesuffix(".")
        return Command(run.__name__.rstrip("_"), text, rest, arguments, run)

    return made


def path(text: str) -> Path:
    """Return the path that an argument is."""
    return Path(text).expanduser()


def flag(name: str, text: str) -> Argument:
    """Return an option without a value; ``--no-NAME`` makes NAME false."""
    dest, off = name.removeprefix("--no-").removeprefix("--"), name.startswith("--no-")
    return argument(name, text, dest=dest, action="store_false" if off else "store_true")


SCENARIO = argument("scenario", "name, or a YAML file", metavar="SCENARIO")
KEPT: Any = {"type": path, "metavar": "FOLDER"}
FOLDER = argument("folder", "a session folder", **KEPT)
OUT = argument("--out", **KEPT)
USERS = argument("--users", "number of users, 1 to 8", type=int, metavar="N")
DURATION = argument("--duration", "length of the session in s", type=float, metavar="S")
COLLECTED: Any = {"dest": "settings", "action": "append", "default": [], "metavar": "NAME=VALUE"}
SET = argument("--set", "change a parameter; may be repeated, the last counts", **COLLECTED)
JSON = flag("--json", "print JSON on stdout and nothing else")
SUMMARY = JSON.but("print summary.json on stdout and nothing else")
COMPARISON = JSON.but("print comparison.json on stdout and nothing else")
LIVE = flag("--live", "use the loop phases of a live session")
CHECK = flag(
    "--check",
    "exit with 1 unless the session was stable, passive, uninterrupted, undisturbed and recorded "
    "whole",
)
NO_FIGURES = flag("--no-figures", "write numbers only")
NEW_FOLDER = OUT.but("session folder, new or empty (default: sessions/<UTC time>-<scenario>)")
ADDRESS = "address of the page (127.0.0.1: this machine only; 0.0.0.0: the network, by token)"
GIVEN = (SCENARIO, USERS, SET)
MODEL = (*GIVEN, LIVE)  # for questions about the model of a scenario
SESSION = (SCENARIO, USERS, DURATION, SET, NEW_FOLDER, CHECK, NO_FIGURES, SUMMARY)
PAGE = (  # of commands that serve one
    argument("--host", ADDRESS, default="127.0.0.1"),
    argument("--port", "port of the page (0: any free one)", type=int, default=0),
    flag("--no-browser", "only print the address of the page"),
)


def scenario_of(arguments: argparse.Namespace) -> "Scenario":
    """Return the scenario named; ScenarioError with every mistake."""
    from pmwvc_bringup import scenarios

    return scenarios.load(
        getattr(arguments, "scenario", None) or arguments.what,
        settings_texts=arguments.settings,
        users=arguments.users,
        duration_s=getattr(arguments, "duration", None),
    )
