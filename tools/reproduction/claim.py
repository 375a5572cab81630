# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A quantitative claim of the dissertation, and how ours compares."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

REPRODUCED = "reproduced"
WITHIN = 0.05  # relative difference up to which a number counts as reproduced
Numbers = dict[str, dict[str, Any]]  # figure -> its numbers


@dataclass(frozen=True)
class Claim:
    """One claim.

    Attributes
    ----------
    where
        Place in the dissertation.
    says
        What is claimed.
    choice
        The modelling choice that decides, or why it cannot be told.
    ours
        From the numbers of the figures; None: cannot be told here.
    printed
        The value; None where the claim is a bound only.
    at_least, at_most
        Bounds that have to hold.
    unit, within
        Of the value; relative difference that counts as reproduced.
    only
        Why the number says less than the claim though it agrees: a condition that the text
        excludes, a coincidence, the window of the plot, a part that is not passive, a triviality.
    """

    where: str
    says: str
    choice: str
    ours: Callable[[Numbers], float | None] | None = None
    printed: float | None = None
    at_least: float | None = None
    at_most: float | None = None
    unit: str = ""
    within: float = WITHIN
    only: str = ""


def row(claim: Claim, numbers: Numbers) -> tuple[str, str, str]:
    """Return printed value, ours and verdict in words."""
    if claim.ours is None:
        return _shown(claim.printed, claim.unit), "-", "cannot be told"
    value = claim.ours(numbers)
    printed = _expected(claim)
    if value is None:
        return printed, "no limit found", "differs: no limit found"
    found = verdict(claim, value)
    if claim.only and found.startswith(REPRODUCED):
        found = f"the number agrees, {claim.only}"
    return printed, _shown(value, claim.unit), found


def verdict(claim: Claim, value: float) -> str:
    """Compare a value with what is claimed."""
    if claim.at_least is not None and value < claim.at_least:
        return f"differs by {_shown(value - claim.at_least, claim.unit)}"
    if claim.at_most is not None and value > claim.at_most:
        return f"differs by {_shown(value - claim.at_most, claim.unit)}"
    if claim.printed is None:
        return "reproduced"
    if claim.printed == 0.0:
        near = abs(value) <= claim.within
        return "reproduced" if near else f"differs by {_shown(value, claim.unit)}"
    relative = value / claim.printed - 1.0
    if abs(relative) <= claim.within:
        return f"reproduced ({relative:+.1%})"
    return f"differs by {relative:+.1%}"


def _expected(claim: Claim) -> str:
    if claim.printed is not None:
        return _shown(claim.printed, claim.unit)
    low, high = claim.at_least, claim.at_most
    if low is not None:
        return f">= {_shown(low, claim.unit)}"
    return f"<= {_shown(high, claim.unit)}" if high is not None else "-"


def _shown(value: float | None, unit: str) -> str:
    if value is None:
        return "-"
    return f"{value:.4g} {unit}".strip()
