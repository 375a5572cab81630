# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A fault, and what came of trying it."""

from collections.abc import Callable
from dataclasses import dataclass, field

HELD, FAILED = "held", "**not held**"


@dataclass(frozen=True)
class Outcome:
    """The result of a fault: whether everything held, and the numbers."""

    held: bool
    seen: str

    @property
    def word(self) -> str:
        """Return the verdict in a word."""
        return HELD if self.held else FAILED


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
