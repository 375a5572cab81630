# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The faults of an environment's answer, and their count."""

from collections.abc import Iterable
from typing import Any

from pmwvc_core.errors import reason


class Unanswered(Exception):
    """The environment has not answered in time, or is still busy with an earlier step."""


class BadAnswer(Exception):
    """The environment answered with something that is no answer."""


class Unsettled(Exception):
    """The equation of a step was not solved to rounding; its best solution was used."""

    def __str__(self) -> str:
        """Return what happened, with the runs it happened in."""
        return f"did not settle {super().__str__()}".rstrip()


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
        known = isinstance(error, (Unanswered, BadAnswer, Unsettled))
        what = str(error) if known else f"raised {reason(error)}"
        self.steps += 1
        self.text = f"{self._name} {what}"
