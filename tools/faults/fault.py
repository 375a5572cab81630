# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A fault, and what came of trying it."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from pmwvc_analysis.traces.thresholds import BLOW_N, BREAK_S

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


def undisturbed(summary: dict[str, Any]) -> tuple[bool, str]:
    """Tell whether no hand felt a blow, nor lost coupling or force beside what was done to it."""
    users = summary["users"]
    step_n = max(user["force_step_max_n"] for user in users)
    gone_s = max(user["disturbed_s"] for user in users)
    text = f"step {step_n:.2f} N"
    held_n = [u["force_least_n"] for u in users if u["force_least_n"] is not None]
    if held_n:
        below_s = max(user["dropout_s"] or 0.0 for user in users)
        text += f"; least force {min(held_n):.2f} N" + _lasting(", below half for", below_s)
    text += _lasting(", beside the fault", gone_s)
    return step_n <= BLOW_N and gone_s <= BREAK_S, text


def _lasting(words: str, time_s: float) -> str:
    return f"{words} {1e3 * time_s:.0f} ms" if time_s > 0.5e-3 else ""
