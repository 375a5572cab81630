# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What can be wrong with an environment's answer, and the count of it."""

from pmwvc_core.errors import reason


class Unanswered(Exception):
    """The environment has not answered in time, or is still busy with an earlier step."""


class BadAnswer(Exception):
    """The environment answered with something that is no answer."""


class Faults:
    """How many steps an environment had to be contained in, and why at last.

    Parameters
    ----------
    name
        ``server.environment``.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self.steps = 0
        self.text = ""

    def note(self, error: BaseException) -> None:
        """Count a step."""
        known = isinstance(error, (Unanswered, BadAnswer))
        what = str(error) if known else f"raised {reason(error)}"
        self.steps += 1
        self.text = f"server.environment = {self._name!r} {what}"
