# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The exception tree: our own mistakes and a user's wrong settings raise; a peer's bad packet is
counted and dropped.

::

    PmwvcError
    ├── ParameterError        one value is outside what it may be
    │   └── ScenarioError     a scenario file or override; lists every mistake it holds
    ├── RecordingError        a recorded file or a session folder cannot be used
    └── DeviceError           a device cannot be opened, calibrated or read
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any


class PmwvcError(Exception):
    """Base of everything this project raises on purpose."""


class ParameterError(PmwvcError, ValueError):
    """A parameter has a wrong value; the message names it, the value and the range."""


class ScenarioError(ParameterError):
    """A scenario holds mistakes; ``problems`` lists all of them, one line each."""

    def __init__(self, source: str, problems: list[str]) -> None:
        self.source, self.problems = source, problems
        lines = "".join(f"\n  - {problem}" for problem in problems)
        text = problems[0] if len(problems) == 1 else f"{len(problems)} problems{lines}"
        super().__init__(f"{source}: {text}")


class RecordingError(PmwvcError):
    """A recorded file cannot be used; the message names it, the reason and the remedy."""


class DeviceError(PmwvcError):
    """A device cannot be used; the message gives cause and remedy."""


@contextmanager
def file_errors(doing: str, remedy: str = "") -> Iterator[None]:
    """Raise ``RecordingError``, "cannot DOING: why", where the system refuses a file or folder."""
    try:
        yield
    except OSError as error:
        raise RecordingError(f"cannot {doing}: {error.strerror or error}{remedy}") from error


def refusal(ask: Callable[..., object], *arguments: Any) -> str:
    """Return why a call refuses its arguments by a ``ParameterError``; "" where it does not."""
    try:
        ask(*arguments)
    except ParameterError as error:
        return str(error)
    return ""


# What a plug-in may raise; its sys.exit() must not end the session either.
PLUGIN_ERRORS = (Exception, SystemExit)


def reason(error: BaseException) -> str:
    """Return type and text of an error of a plug-in, in one line."""
    return " ".join(f"{type(error).__name__}: {error}".split())
