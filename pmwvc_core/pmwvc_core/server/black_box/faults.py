# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The faults of an environment's answer, and their count."""

from typing import Any

from pmwvc_core.errors import reason
from pmwvc_core.numeric import Flags


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

    def note_users(self, good: Flags, what: str) -> None:
        """Count a step where the answer is not good for all users ``(users, ..., 1)``."""
        if not good.all():
            who = [user for user, each in enumerate(good) if not each.all()]
            self.note(BadAnswer(f"returned {what} for users {who}"))

    def note_jumps(self, body: Any) -> None:
        """Count a step of an environment whose force jumped for users who are there."""
        users = enumerate(getattr(body, "users", ()))
        if who := [user for user, seen in users if seen.there and seen.jumped]:
            what = "returned a force that jumped while hardly anything moved"
            self.note(BadAnswer(f"{what} for users {who}"))

    def note(self, error: BaseException) -> None:
        """Count a step."""
        known = isinstance(error, (Unanswered, BadAnswer, Unsettled))
        what = str(error) if known else f"raised {reason(error)}"
        self.steps += 1
        self.text = f"{self._name} {what}"
