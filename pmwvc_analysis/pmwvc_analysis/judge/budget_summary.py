# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""An energy budget as plain numbers (``budget.json``), as a table, and in sentences."""

from dataclasses import asdict
from typing import Any

import numpy as np

from pmwvc_analysis.judge.budget_result import SERVER, Active, Budget
from pmwvc_analysis.judge.budget_words import words_of
from pmwvc_core.numeric import Array

WORTH_SAYING = 1e-2  # of the energy moved: what is said of an active part in sentences
MOST_SAID = 3


def summary(found: Budget) -> dict[str, Any]:
    """Return a budget as plain numbers: the contents of ``budget.json``."""

    def last(sums: Array) -> float:
        return float(sums[-1])

    worst = int(np.argmax(np.abs(found.residual_j)))
    return {
        "until_s": float(found.time_s[-1]),
        "hands_j": sum(last(sums) for sums in found.hands.values()),
        "moved_j": found.moved_j,
        "residual_j": last(found.residual_j),
        "residual_largest_j": float(np.abs(found.residual_j[worst])),
        "tolerance_j": found.tolerance_j,
        "closes": found.closes,
        "users": [
            {
                "name": name,
                "hand_j": last(found.hands[name]),
                **{f"{part}_j": last(sums) for part, sums in found.parts[name].items()},
                "residual_j": last(found.residuals[name]),
            }
            for name in found.hands
        ],
        "server": {
            **{f"{part}_j": last(sums) for part, sums in found.parts[SERVER].items()},
            "residual_j": last(found.residuals[SERVER]),
        },
        "active": [asdict(entry) for entry in found.active],
        "notes": found.notes,
    }


def rows(found: Budget) -> list[tuple[str, list[float | None]]]:
    """Return the final energies [J] as a table: a label, then one column per user and the server.

    A part that does not exist there is None.
    """
    owners = [*found.hands, SERVER]
    table: list[tuple[str, list[float | None]]] = [
        ("given by the hand", [*(float(s[-1]) for s in found.hands.values()), None])
    ]
    parts = list(dict.fromkeys(part for owner in owners for part in found.parts[owner]))
    for part in parts:
        sums = [found.parts[owner].get(part) for owner in owners]
        table.append((words_of(part), [None if s is None else float(s[-1]) for s in sums]))
    table.append(("not explained", [float(found.residuals[owner][-1]) for owner in owners]))
    return table


def lines(found: Budget) -> list[tuple[bool, str]]:
    """Return in words whether the budget closes and which part was active; each good or bad."""
    residual = float(np.abs(found.residual_j).max())
    if found.closes:
        said = [(True, f"The energy budget closes to {_joule(residual)}.")]
    else:
        said = [
            (False, f"The energy budget does not close: {_joule(residual)} are not explained.")
        ]
    large = active_sentences(found)
    if not large:
        return [*said, (True, "No part gave out energy that it had not got.")]
    return said + [(False, words) for words in large]


def active_sentences(found: Budget) -> list[str]:
    """Return in words what was active beyond a small share of the energy moved, worst first."""
    return [_sentence(entry) for entry in worth_saying(found)]


def worth_saying(found: Budget) -> list[Active]:
    """Return the few worst active parts that gave out a share of the energy moved."""
    large = [entry for entry in found.active if entry.given_j > WORTH_SAYING * found.moved_j]
    return large[:MOST_SAID]


def _sentence(entry: Active) -> str:
    where = "at the server" if entry.owner == SERVER else f"of {entry.owner}"
    return (
        f"Active, {where}: {words_of(entry.part)} gave out {_joule(entry.given_j)} more than it "
        f"had got, at {entry.time_s:.2f} s (first seen at {entry.since_s:.2f} s)."
    )


def _joule(value: float) -> str:
    for size, unit in ((1.0, "J"), (1e-3, "mJ"), (1e-6, "µJ")):
        if value >= size:
            return f"{value / size:.3g} {unit}"
    return "less than 1 µJ"
