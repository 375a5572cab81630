# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""An energy budget as numbers over time, whether it closes, and which parts released energy.

A part whose running sum fell below zero released energy that it had not received, unless its
owner declared that. Others may have paid for it: the ports decide (:mod:`..verdicts.passivity`).
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from pmwvc_analysis.budget.criterion import Balance, Finding
from pmwvc_analysis.budget.parts import words_of
from pmwvc_analysis.traces.thresholds import CLOSED, CLOSED_NOTED, SMALLEST_J
from pmwvc_core.numeric import Array

SERVER = "server"
# Of a device that shows something else than it does, and of ticks that were skipped, these are
# what the others leave: that is no release.
OPEN = "device_damping", "sample_hold"

Sums = dict[str, Array]  # running sums [J] by part


@dataclass(frozen=True)
class Budget:
    """Running energies at ``time_s``; by owner (a user, or ``server``), then by part [J]."""

    time_s: Array
    hands: dict[str, Array]
    parts: dict[str, Sums]
    residuals: dict[str, Array]
    notes: list[str] = field(default_factory=list)  # what keeps it from closing to rounding
    declared_j: dict[str, float] = field(default_factory=dict)  # at the start, by user
    # owners and parts that it does not compute for themselves: no error in these is found
    remainders: list[tuple[str, str]] = field(default_factory=list)
    server_is_whole: bool = True  # else its parts, summed step by step, are not known

    @property
    def residual_j(self) -> Array:
        """Energy that the parts do not explain [J]."""
        return np.asarray(sum(self.residuals.values()), dtype=float)

    @property
    def moved_j(self) -> float:
        """Energy that went through the hands, either way, or was held somewhere: the scale."""
        hands = sum(float(np.abs(np.diff(sums)).sum()) for sums in self.hands.values())
        held = (float(np.abs(s).max()) for each in self.parts.values() for s in each.values())
        return max(hands, *held, SMALLEST_J)

    @property
    def tolerance_j(self) -> float:
        """Largest residual with which the budget closes [J]."""
        return SMALLEST_J + (CLOSED_NOTED if self.notes else CLOSED) * self.moved_j

    @property
    def closes(self) -> bool:
        """Tell whether the residual was never larger than that."""
        return bool(np.abs(self.residual_j).max(initial=0.0) <= self.tolerance_j)

    @property
    def released(self) -> list[Finding]:
        """Return the parts that released energy that they had not received, most first."""
        moved_j, found = self.moved_j, []
        for owner, parts in self.parts.items():
            declared_j = self.declared_j.get(owner, 0.0)
            for part, sums in parts.items() if owner != SERVER or self.server_is_whole else ():
                own = self.time_s, sums, 0.0 * sums, declared_j
                if part not in OPEN or (owner, part) not in self.remainders:
                    found.append(Balance(*own, moved_j=moved_j).judged(owner, part))
        active = [each for each in found if each.passive is False]
        return sorted(active, key=lambda each: -each.given_j)

    def summary(self) -> dict[str, Any]:
        """Return the budget as plain numbers: the contents of ``budget.json``."""
        return {
            "until_s": float(self.time_s[-1]),
            "hands_j": sum(_last(sums) for sums in self.hands.values()),
            "moved_j": self.moved_j,
            "residual_j": _last(self.residual_j),
            "residual_largest_j": float(np.abs(self.residual_j).max()),
            "tolerance_j": self.tolerance_j,
            "closes": self.closes,
            "users": [
                {"name": name, "hand_j": _last(hand)}
                | self._energies(name)
                | {"declared_storage_j": self.declared_j.get(name, 0.0)}
                for name, hand in self.hands.items()
            ],
            "server": self._energies(SERVER),
            "notes": self.notes,
            "remainders": [{"owner": owner, "part": part} for owner, part in self.remainders],
        }

    def _energies(self, owner: str) -> dict[str, float]:
        parts = {f"{part}_j": _last(sums) for part, sums in self.parts[owner].items()}
        return {**parts, "residual_j": _last(self.residuals[owner])}

    def rows(self) -> list[tuple[str, list[float | None]]]:
        """Return the final energies [J]: label, a column per user and the server; None: none."""
        owners = [*self.hands, SERVER]
        left_over = {part for _, part in self.remainders}
        lines: list[tuple[str, list[Array | None]]] = [
            ("given by the hand", [*self.hands.values(), None])
        ]
        for part in dict.fromkeys(part for owner in owners for part in self.parts[owner]):
            label = words_of(part) + (" (remainder)" if part in left_over else "")
            lines.append((label, [self.parts[owner].get(part) for owner in owners]))
        lines.append(("residual", [self.residuals[owner] for owner in owners]))
        return [(t, [None if s is None else _last(s) for s in row]) for t, row in lines]


def _last(sums: Array) -> float:
    return float(sums[-1])
