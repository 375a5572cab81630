# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Shell completion by argcomplete: commands, options, scenarios, parameters, session folders."""

import argparse
from pathlib import Path
from typing import Any

from pmwvc_bringup import scenarios as files

SHELLS = ("bash", "zsh", "fish")
PROGRAMS = ["pmwvc", "./pmwvc"]
EXAMPLES = """\
examples:
  eval "$(./pmwvc completion)"                 this bash
  ./pmwvc completion zsh >> ~/.zshrc           every zsh from now on
"""


def add(several: Any) -> None:
    """Add the command to the sub-commands of a parser."""
    text = "print the completion script for a shell"
    parser = several.add_parser("completion", help=text, description=f"{text}.", epilog=EXAMPLES)
    parser.set_defaults(command=run)
    parser.add_argument("shell", nargs="?", choices=SHELLS, default="bash", help="bash by default")


def run(arguments: argparse.Namespace) -> int:
    """Print the code."""
    from argcomplete.shell_integration import shellcode

    print(shellcode(PROGRAMS, shell=arguments.shell))
    return 0


def complete(parser: argparse.ArgumentParser) -> None:
    """Answer a shell that asks for completions, and end; does nothing for anybody else."""
    import argcomplete

    _attach(parser)
    argcomplete.autocomplete(parser)


def _attach(parser: argparse.ArgumentParser) -> None:
    """Give the options of a parser and its sub-commands the words they take."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for nested in action.choices.values():
                _attach(nested)
        elif action.metavar == "SCENARIO" or (action.dest, action.metavar) == ("name", "NAME"):
            action.completer = scenario_names  # type: ignore[attr-defined]
        elif action.dest in ("settings", "x", "y"):
            action.completer = parameter_names  # type: ignore[attr-defined]
        elif action.dest in ("folder", "sessions"):
            action.completer = session_folders  # type: ignore[attr-defined]


def scenario_names(**_: Any) -> list[str]:
    """Return the scenarios that come with the project."""
    return list(files.known())


def parameter_names(**_: Any) -> list[str]:
    """Return every parameter of a scenario, ready for its value."""
    from pmwvc_core.network.presets import PRESETS
    from pmwvc_core.params import LinkParams, specs
    from pmwvc_core.scenario.names import shared_specs, user_specs

    links = [f"link.{name}" for name in specs(LinkParams)]
    networks = [f"link.preset={name}" for name in PRESETS]
    names = [*shared_specs(), *user_specs(), *links]
    return [f"{name}=" for name in names] + networks


def session_folders(prefix: str = "", **_: Any) -> list[str]:
    """Return the folders that begin as the word does, and below ``sessions`` the recorded ones."""
    base = Path(prefix).parent if not prefix.endswith("/") else Path(prefix)
    places = [base, Path("sessions")] if not prefix else [base]
    return [f"{found}/" for place in places if place.is_dir() for found in _folders(place)]


def _folders(place: Path) -> list[Path]:
    return sorted(path for path in place.iterdir() if path.is_dir() and path.name[0] != ".")
