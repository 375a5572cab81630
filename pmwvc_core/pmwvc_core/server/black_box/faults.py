# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The faults of what the server asks, and their count: the guard of code from outside."""

from collections.abc import Callable, Iterable
from typing import Any, TypeVar

from pmwvc_core.errors import PLUGIN_ERRORS, reason

R = TypeVar("R")


class BadAnswer(Exception):
    """The environment or coupling answered with something that is no answer."""


class Unanswered(BadAnswer):
    """It has not answered in time, or is still busy with an earlier step."""


class Unsettled(BadAnswer):
    """The equation of a step was not solved to rounding; its best solution was used."""

    def __str__(self) -> str:
        """Return what happened."""
        return "did not settle"


class Faults:
    """Count of faulty steps, and the text of the last fault.

    Parameters
    ----------
    parameter, value
        What was asked: ``server.environment``, or ``server.coupling``.
    """

    def __init__(self, parameter: str, value: str) -> None:
        self._name = f"{parameter} = {value!r}"
        self.steps = 0
        self.text = ""
        self.what = parameter.removeprefix("server.")
        self.replaced = self.what == "environment"  # by a damper, in those steps

    def guarded(self, ask: Callable[[], R]) -> R | None:
        """Return what code from outside answers; None, and count a step, where it raises."""
        try:
            return ask()
        except PLUGIN_ERRORS as error:  # whatever it raises
            self.note(error)
            return None

    def note_users(self, bad: Iterable[bool], what: str) -> None:
        """Count a step where the answer is bad for any user."""
        if who := [user for user, is_bad in enumerate(bad) if is_bad]:
            self.note(BadAnswer(f"returned {what} for users {who}"))

    def note_jumps(self, body: Any) -> None:
        """Count a step of an environment whose force jumped for users who are there."""
        jumped = (seen.there and seen.jumped for seen in getattr(body, "users", ()))
        self.note_users(jumped, "a force that jumped while hardly anything moved")

    def note(self, error: BaseException) -> None:
        """Count a step."""
        what = str(error) if isinstance(error, BadAnswer) else f"raised {reason(error)}"
        self.steps += 1
        self.text = f"{self._name} {what}"
