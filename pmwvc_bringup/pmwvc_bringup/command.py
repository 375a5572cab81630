# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A command as a record: its name, help, examples, arguments and the function behind it; and the
arguments that several commands take, each declared once.

A function in a module below :mod:`pmwvc_bringup.commands` that is decorated with :func:`command`
is a command. Heavy imports stand inside functions: ``pmwvc --help`` has to answer at once.
"""

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from pmwvc_core.scenario.scenario import Scenario

Argument = Callable[[argparse.ArgumentParser], None]


def argument(
    *names: str, completer: Callable[..., list[str]] | None = None, **options: Any
) -> Argument:
    """Return what adds an argument to a parser, with the options of ``add_argument`` and the words
    that a shell may offer for it.
    """

    def add_to(parser: argparse.ArgumentParser) -> None:
        action = parser.add_argument(*names, **options)
        if completer is not None:
            action.completer = completer  # type: ignore[attr-defined]

    return add_to


class Result(NamedTuple):
    """The exit code of a command, and the document that it prints with ``--json``."""

    code: int = 0
    document: object = None  # plain data, or the text of a JSON file


class Command(NamedTuple):
    """One command of ``pmwvc``; ``run`` raises ``PmwvcError`` for a mistake of the user (exit
    code 2).
    """

    name: str
    help: str  # one clause, without a full stop
    examples: str  # printed below the options
    arguments: tuple[Argument, ...]
    run: Callable[[argparse.Namespace], Result]


def command(
    name: str, help_text: str, examples: str, *arguments: Argument
) -> Callable[[Callable[[argparse.Namespace], Result]], Command]:
    """Make a function a command."""
    return lambda run: Command(name, help_text, examples, arguments, run)


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
        name, before = values.partition("=")[0].strip(), getattr(namespace, self.dest)
        if name in [text.partition("=")[0].strip() for text in before]:
            parser.error(f"{option_string} {values}: {name} is given twice")
        setattr(namespace, self.dest, [*before, values])


def settings(target: str = "a parameter") -> Argument:
    """Return ``--set``."""
    options = {"metavar": "NAME=VALUE", "help": f"change {target}; may be repeated"}
    kept = {"dest": "settings", "action": _Once, "default": []}
    return argument("--set", completer=parameter_names, **options, **kept)


def duration(sessions: str = "the session") -> Argument:
    """Return ``--duration``."""
    return argument("--duration", type=float, metavar="S", help=f"length of {sessions} in s")


def out(text: str, *, metavar: str = "FOLDER") -> Argument:
    """Return ``--out``."""
    return argument("--out", type=path, metavar=metavar, help=text)


def json_document(text: str = "print JSON on stdout and nothing else") -> Argument:
    """Return ``--json``."""
    return argument("--json", action="store_true", help=text)


def flag(name: str, text: str) -> Argument:
    """Return an option without a value; ``--no-NAME`` makes NAME false."""
    dest, off = name.removeprefix("--no-").removeprefix("--"), name.startswith("--no-")
    return argument(name, dest=dest, action="store_false" if off else "store_true", help=text)


def path(text: str) -> Path:
    """Return the path that an argument is."""
    return Path(text).expanduser()


def scenario(name: str = "scenario", **options: Any) -> Argument:
    """Return the argument that is a scenario."""
    named = {"metavar": name.upper(), "help": "name, or a YAML file"}
    return argument(name, completer=scenario_names, **named, **options)


def folder(name: str = "folder", text: str = "a session folder", **options: Any) -> Argument:
    """Return the argument that is a session folder, or several."""
    named: dict[str, Any] = {"type": path, "metavar": "FOLDER", "help": text}
    return argument(name, completer=session_folders, **named, **options)


SCENARIO, FOLDER = scenario(), folder()
USERS = argument("--users", type=int, metavar="N", help="number of users, 1 to 8")
LIVE = flag("--live", "use the loop phases of a live session")
CHECK = flag(
    "--check",
    "exit with 1 unless the session was stable, passive, uninterrupted, undisturbed and recorded "
    "whole",
)
NO_FIGURES = flag("--no-figures", "write numbers only")
GIVEN = (SCENARIO, USERS, settings())
SESSION = (
    *(SCENARIO, USERS, duration(), settings()),
    out("session folder, new or empty (default: sessions/<UTC time>-<scenario>)"),
    *(CHECK, NO_FIGURES, json_document("print summary.json on stdout and nothing else")),
)
ADDRESS = "address of the page (127.0.0.1: this machine only; 0.0.0.0: the network, by token)"
PAGE = (  # of commands that serve one
    argument("--host", default="127.0.0.1", help=ADDRESS),
    argument("--port", type=int, default=0, help="port of the page (0: any free one)"),
    flag("--no-browser", "only print the address of the page"),
)
MODEL = (*GIVEN, LIVE)  # for questions about the model of a scenario


def scenario_of(arguments: argparse.Namespace) -> "Scenario":
    """Return the scenario named, and print on stderr what is unusual about it; ScenarioError with
    every mistake of file and options.
    """
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
