# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A command as a record: its name, help, examples, arguments and the function behind it.

A function in a module below :mod:`pmwvc_bringup.commands` that is decorated with :func:`command`
is a command. Heavy imports stand inside functions: ``pmwvc --help`` has to answer at once.
"""

import argparse
from collections.abc import Callable
from typing import Any, NamedTuple

Completer = Callable[..., list[str]]
Argument = Callable[[argparse.ArgumentParser], None]


def argument(*names: str, completer: Completer | None = None, **options: Any) -> Argument:
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
    help: str
    examples: str
    arguments: tuple[Argument, ...]
    run: Callable[[argparse.Namespace], Result]


def command(
    name: str, help_text: str, examples: str, *arguments: Argument
) -> Callable[[Callable[[argparse.Namespace], Result]], Command]:
    """Make a function a command. ``help_text`` is one clause, without a full stop; ``examples``
    are printed below the options.
    """
    return lambda run: Command(name, help_text, examples, arguments, run)
