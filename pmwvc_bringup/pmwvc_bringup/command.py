# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A command as a record: its name, help, examples, arguments and the function behind it; and the
arguments that several commands take, each declared once.

A function in a module below :mod:`pmwvc_bringup.commands` that is decorated with :func:`command`
is a command. Heavy imports stand inside functions: ``pmwvc --help`` has to answer at once.
"""

import argparse
import inspect
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from pmwvc_core.scenario.scenario import Scenario


class Argument(NamedTuple):
    """An argument: names, options of ``add_argument``, and the words that a shell may offer."""

    names: tuple[str, ...]
    options: Mapping[str, Any]
    completer: Callable[..., list[str]] | None = None

    def named(self, name: str) -> "Argument":
        """Return the same argument by another name."""
        return self._replace(names=(name,))

    def but(self, **options: Any) -> "Argument":
        """Return the same argument with other options."""
        return self._replace(options={**self.options, **options})


def argument(
    *names: str, completer: Callable[..., list[str]] | None = None, **options: Any
) -> Argument:
    """Return an argument."""
    return Argument(names, options, completer)


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


def scenario_names(**_: object) -> list[str]:
    """Return the scenarios that come with the project."""
    from pmwvc_bringup import scenarios

    return list(scenarios.known())


def parameter_names(**_: object) -> list[str]:
    """Return every parameter of a scenario, ready for its value."""
    from pmwvc_core.network.presets import PRESETS
    from pmwvc_core.params import LinkParams, specs
    from pmwvc_core.scenario.scenario import PARAMETERS

    names = [*PARAMETERS, *(f"link.{name}" for name in specs(LinkParams))]
    return [f"{name}=" for name in names] + [f"link.preset={name}" for name in PRESETS]


def session_folders(prefix: str = "", **_: object) -> list[str]:
    """Return the folders that begin as the word does; without a word, also recorded sessions."""
    base = Path(prefix).parent if not prefix.endswith("/") else Path(prefix)
    parents = [base] if prefix else [base, Path("sessions")]
    return [
        f"{path}/"
        for parent in parents
        if parent.is_dir()
        for path in sorted(parent.iterdir())
        if path.is_dir() and path.name[0] != "."
    ]


class _Once(argparse.Action):
    """Collects NAME=VALUE texts; a name given twice is a mistake."""

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, values: Any,
        option_string: str | None = None,
    ) -> None:  # fmt: skip
        """Add a text to those before."""
        texts = [*getattr(namespace, self.dest), values]
        *before, name = [text.partition("=")[0].strip() for text in texts]
        if name in before:
            parser.error(f"{option_string} {values}: {name} is given twice")
        setattr(namespace, self.dest, texts)


def path(text: str) -> Path:
    """Return the path that an argument is."""
    return Path(text).expanduser()


def flag(name: str, text: str) -> Argument:
    """Return an option without a value; ``--no-NAME`` makes NAME false."""
    dest, off = name.removeprefix("--no-").removeprefix("--"), name.startswith("--no-")
    return argument(name, dest=dest, action="store_false" if off else "store_true", help=text)


NAMED: Any = {"completer": scenario_names, "help": "name, or a YAML file"}
SCENARIO = argument("scenario", metavar="SCENARIO", **NAMED)
KEPT: Any = {"type": path, "metavar": "FOLDER"}
FOLDER = argument("folder", completer=session_folders, help="a session folder", **KEPT)
OUT = argument("--out", **KEPT)
USERS = argument("--users", type=int, metavar="N", help="number of users, 1 to 8")
DURATION = argument("--duration", type=float, metavar="S", help="length of the session in s")
COLLECTED: Any = {"dest": "settings", "action": _Once, "default": [], "metavar": "NAME=VALUE"}
SET = argument(
    "--set", completer=parameter_names, help="change a parameter; may be repeated", **COLLECTED
)
JSON = flag("--json", "print JSON on stdout and nothing else")
SUMMARY = JSON.but(help="print summary.json on stdout and nothing else")
COMPARISON = JSON.but(help="print comparison.json on stdout and nothing else")
LIVE = flag("--live", "use the loop phases of a live session")
CHECK = flag(
    "--check",
    "exit with 1 unless the session was stable, passive, uninterrupted, undisturbed and recorded "
    "whole",
)
NO_FIGURES = flag("--no-figures", "write numbers only")
NEW_FOLDER = OUT.but(help="session folder, new or empty (default: sessions/<UTC time>-<scenario>)")
ADDRESS = "address of the page (127.0.0.1: this machine only; 0.0.0.0: the network, by token)"
GIVEN = (SCENARIO, USERS, SET)
MODEL = (*GIVEN, LIVE)  # for questions about the model of a scenario
SESSION = (SCENARIO, USERS, DURATION, SET, NEW_FOLDER, CHECK, NO_FIGURES, SUMMARY)
PAGE = (  # of commands that serve one
    argument("--host", default="127.0.0.1", help=ADDRESS),
    argument("--port", type=int, default=0, help="port of the page (0: any free one)"),
    flag("--no-browser", "only print the address of the page"),
)


def scenario_of(arguments: argparse.Namespace) -> "Scenario":
    """Return the scenario named, and print what is unusual; ScenarioError with every mistake."""
    from pmwvc_bringup import scenarios
    from pmwvc_core.scenario.names import doubts

    found = scenarios.load(
        getattr(arguments, "scenario", None) or arguments.what,
        settings_texts=arguments.settings,
        users=arguments.users,
        duration_s=getattr(arguments, "duration", None),
    )
    for line in doubts(found):
        print(f"pmwvc: {line}", file=sys.stderr)
    return found
