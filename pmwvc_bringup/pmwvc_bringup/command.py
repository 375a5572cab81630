# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A command as a record: its name, help, examples, arguments and the function behind it.

A module below :mod:`pmwvc_bringup.commands` that has a record named ``COMMAND`` is a command.
Heavy imports stand inside its functions: ``pmwvc --help`` has to answer at once.
"""

import argparse
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

Completer = Callable[..., list[str]]


class Argument(NamedTuple):
    """One argument or option, as ``argparse`` takes it, and the words a shell may offer for it."""

    names: tuple[str, ...]
    options: Mapping[str, Any]
    completer: Completer | None

    def add_to(self, parser: argparse.ArgumentParser) -> None:
        """Add the argument to a parser."""
        action = parser.add_argument(*self.names, **self.options)
        if self.completer is not None:
            action.completer = self.completer  # type: ignore[attr-defined]


def argument(*names: str, completer: Completer | None = None, **options: Any) -> Argument:
    """Declare an argument with the options of ``ArgumentParser.add_argument``."""
    return Argument(names, options, completer)


class Result(NamedTuple):
    """The exit code of a command, and the document that it prints with ``--json``."""

    code: int = 0
    document: object = None  # plain data, or the text of a JSON file


@dataclass(frozen=True)
class Command:
    """One command of ``pmwvc``.

    ``help`` is one clause, without a full stop; ``examples`` are printed below the options;
    ``run`` raises ``PmwvcError`` for a mistake of the user (exit code 2).
    """

    name: str
    help: str
    examples: str
    arguments: tuple[Argument, ...]
    run: Callable[[argparse.Namespace], Result]
