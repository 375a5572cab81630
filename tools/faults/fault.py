# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A fault, and what came of trying it."""

from collections.abc import Callable
from dataclasses import dataclass, field

HELD, FAILED, NOT_TRIED = "held", "**not held**", "not tried"


@dataclass(frozen=True)
class Outcome:
    """What was seen: whether everything held, and the numbers; ``None``: it was not tried."""

    held: bool | None
    seen: str

    @property
    def word(self) -> str:
        """Return the verdict in a word."""
        return NOT_TRIED if self.held is None else HELD if self.held else FAILED


@dataclass(frozen=True)
class Fault:
    """A fault: its number, what is done, what has to hold, and what tries it.

    Attributes
    ----------
    live
        Whether real processes take part.
    """

    number: str
    done: str
    wanted: str
    attempt: Callable[[], Outcome]
    live: bool = field(default=False)


def joined(*parts: tuple[bool, str]) -> Outcome:
    """Return the outcome of several conditions, each with what was seen of it."""
    return Outcome(all(held for held, _ in parts), "; ".join(text for _, text in parts))


def untried(reason: str) -> Callable[[], Outcome]:
    """Return the attempt of a fault that is not tried, for a reason."""
    return lambda: Outcome(None, reason)
