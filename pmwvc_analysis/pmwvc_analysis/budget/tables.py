# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""An energy budget as plain numbers (``budget.json``), and as a table."""

from typing import Any

import numpy as np

from pmwvc_analysis.budget.criterion import Finding
from pmwvc_analysis.budget.parts import words_of
from pmwvc_analysis.budget.result import SERVER, Budget
from pmwvc_core.numeric import Array

DRAWN = 3  # active parts in a figure, which has no room for small ones
DRAWN_RATIO = 1e-2  # of the energy moved


def summary(found: Budget) -> dict[str, Any]:
    """Return a budget as plain numbers: the contents of ``budget.json``."""
    return {
        "until_s": float(found.time_s[-1]),
        "hands_j": sum(_last(sums) for sums in found.hands.values()),
        "moved_j": found.moved_j,
        "residual_j": _last(found.residual_j),
        "residual_largest_j": float(np.abs(found.residual_j).max()),
        "tolerance_j": found.tolerance_j,
        "closes": found.closes,
        "users": [
            {
                "name": name,
                "hand_j": _last(found.hands[name]),
                **_energies(found, name),
                "declared_storage_j": sum(found.declared.get(name, ())),
            }
            for name in found.hands
        ],
        "server": _energies(found, SERVER),
        "active": [_active(entry) for entry in found.active],
        "notes": found.notes,
        "remainders": [
            {"owner": each.owner, "part": each.part, "hides": each.hides}
            for each in found.remainders
        ],
    }


def _energies(found: Budget, owner: str) -> dict[str, float]:
    parts = {f"{part}_j": _last(sums) for part, sums in found.parts[owner].items()}
    return {**parts, "residual_j": _last(found.residuals[owner])}


def _last(sums: Array) -> float:
    return float(sums[-1])


def rows(found: Budget) -> list[tuple[str, list[float | None]]]:
    """Return the final energies [J] as a table: a label, then one column per user and the server.

    A part that does not exist there is None.
    """
    owners = [*found.hands, SERVER]
    table: list[tuple[str, list[float | None]]] = [
        ("given by the hand", [*map(_last, found.hands.values()), None])
    ]
    left_over = {each.part for each in found.remainders}
    parts = list(dict.fromkeys(part for owner in owners for part in found.parts[owner]))
    for part in parts:
        sums = [found.parts[owner].get(part) for owner in owners]
        label = words_of(part) + (" (remainder)" if part in left_over else "")
        table.append((label, [None if s is None else _last(s) for s in sums]))
    table.append(("residual", [_last(found.residuals[owner]) for owner in owners]))
    return table


def _active(entry: Finding) -> dict[str, Any]:
    return {
        "owner": entry.owner,
        "part": entry.part,
        "given_j": entry.given_j,
        "since_s": entry.since_s,
        "time_s": entry.least_s,
        "tolerance_j": entry.tolerance_j,
        "ratio": entry.ratio,
    }


def worth_drawing(found: Budget) -> list[Finding]:
    """Return the few worst active parts that show beside the energy moved."""
    return [entry for entry in found.active if entry.ratio > DRAWN_RATIO][:DRAWN]
