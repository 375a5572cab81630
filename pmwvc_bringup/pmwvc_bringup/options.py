# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Arguments that several commands take, each declared once, and the words offered for them."""

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pmwvc_bringup.command import Argument, argument

if TYPE_CHECKING:
    from pmwvc_core.scenario.scenario import Scenario


def scenario_names(**_: object) -> list[str]:
    """Return the scenarios that come with the project."""
    from pmwvc_bringup import scenarios

    return list(scenarios.known())


def parameter_names(**_: object) -> list[str]:
    """Return every parameter of a scenario, ready for its value."""
    from pmwvc_core.network.presets import PRESETS
    from pmwvc_core.params import LinkParams, specs
    from pmwvc_core.scenario.scenario import PARAMETERS

    links = [f"link.{name}" for name in specs(LinkParams)]
    networks = [f"link.preset={name}" for name in PRESETS]
    names = [*PARAMETERS, *links]
    return [f"{name}=" for name in names] + networks


def session_folders(prefix: str = "", **_: object) -> list[str]:
    """Return the folders that begin as the word does; without a word, also recorded sessions."""
    base = Path(prefix).parent if not prefix.endswith("/") else Path(prefix)
    parents = [base, Path("sessions")] if not prefix else [base]
    return [
        f"{path}/"
        for parent in parents
        if parent.is_dir()
        for path in sorted(parent.iterdir())
        if path.is_dir() and path.name[0] != "."
    ]


SCENARIO = argument(
    "scenario", metavar="SCENARIO", help="name, or a YAML file", completer=scenario_names
)
USERS = argument("--users", type=int, metavar="N", help="number of users, 1 to 8")
FOLDER = argument("folder", metavar="FOLDER", help="a session folder", completer=session_folders)
LIVE = argument("--live", action="store_true", help="use the loop phases of a live session")
CHECK = argument(
    "--check",
    action="store_true",
    help="exit with 1 unless the session was stable, passive, uninterrupted, undisturbed and "
    "recorded whole",
)
NO_FIGURES = argument("--no-figures", action="store_true", help="write numbers only")


class _Once(argparse.Action):
    """Collects NAME=VALUE texts; a name given twice is a mistake."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: Any,
        option_string: str | None = None,
    ) -> None:
        """Add a text to those before."""
        name, before = values.partition("=")[0].strip(), getattr(namespace, self.dest)
        if name in [text.partition("=")[0].strip() for text in before]:
            parser.error(f"{option_string} {values}: {name} is given twice")
        setattr(namespace, self.dest, [*before, values])


def settings(target: str = "a parameter") -> Argument:
    """Return ``--set``."""
    return argument(
        "--set",
        action=_Once,
        default=[],
        metavar="NAME=VALUE",
        dest="settings",
        help=f"change {target}; may be repeated",
        completer=parameter_names,
    )


def duration(sessions: str = "the session") -> Argument:
    """Return ``--duration``."""
    return argument("--duration", type=float, metavar="S", help=f"length of {sessions} in s")


def out(text: str, *, metavar: str = "FOLDER") -> Argument:
    """Return ``--out``."""
    return argument("--out", metavar=metavar, help=text)


def json_document(text: str = "print JSON on stdout and nothing else") -> Argument:
    """Return ``--json``."""
    return argument("--json", action="store_true", help=text)


SESSION = (
    SCENARIO,
    USERS,
    duration(),
    settings(),
    out("session folder, new or empty (default: sessions/<UTC time>-<scenario>)"),
    CHECK,
    NO_FIGURES,
    json_document("print summary.json on stdout and nothing else"),
)
PAGE = (  # of commands that serve one
    argument(
        "--host",
        default="127.0.0.1",
        help="address of the page (127.0.0.1: this machine only; 0.0.0.0: the network, by token)",
    ),
    argument("--port", type=int, default=0, help="port of the page (0: any free one)"),
    argument("--no-browser", action="store_true", help="only print the address of the page"),
)
MODEL = (SCENARIO, USERS, settings(), LIVE)  # for questions about the model of a scenario


def scenario_of(arguments: argparse.Namespace) -> "Scenario":
    """Return the scenario named, and print on stderr what is unusual about it; ScenarioError with
    every mistake of file and options.
    """
    from pmwvc_bringup import scenarios
    from pmwvc_core.scenario.names import doubts

    scenario = scenarios.load(
        getattr(arguments, "scenario", None) or arguments.what,
        settings_texts=arguments.settings,
        users=arguments.users,
        duration_s=getattr(arguments, "duration", None),
    )
    for line in doubts(scenario):
        print(f"pmwvc: {line}", file=sys.stderr)
    return scenario
