# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""An energy budget as numbers over time, whether it closes, and which part was active.

A part that is not passive (:mod:`.criterion`) was *active*. What belongs together is judged
together: the anti-aliasing filter pays for the rate drop and for a velocity filter, and a position
feedback with an energy tank spends what filter, hold and link have kept. Behind counts of an
encoder the work of node and sampling is not known, nor is the heat in a device whose velocity is
measured: none is judged.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from pmwvc_analysis.budget.criterion import Balance, Finding
from pmwvc_analysis.budget.parts import accounted, words_of
from pmwvc_analysis.traces.holes import Unjudged
from pmwvc_analysis.traces.sums import sum_of
from pmwvc_analysis.traces.thresholds import CLOSED, CLOSED_NOTED, SMALLEST_J
from pmwvc_core.numeric import Array

SERVER = "server"
# What pays for one another, in this order.
AROUND = ("velocity_filter", "bank", "filter", "filter_and_hold", "rate_drop")
AT_COUNTS = ("sample_hold", "node", "node_and_link_down")  # the true motion less that counted
ENVIRONMENT = ("environment_stored", "environment_heat")
PAID = ("position_spent", *AROUND, "link_down")
PAID_PORT = ("late_decoding", "withheld", *ENVIRONMENT)


Sums = dict[str, Array]  # running sums [J] by part


@dataclass(frozen=True)
class Budget:
    """Running energies at ``time_s``; by owner (a user, or ``server``), then by part [J]."""

    time_s: Array
    hands: dict[str, Array]
    parts: dict[str, Sums]
    residuals: dict[str, Array]
    tanks: frozenset[str] = frozenset()  # owners that release only what their energy tank holds
    notes: list[str] = field(default_factory=list)  # what keeps it from closing to rounding
    declared_j: dict[str, float] = field(default_factory=dict)  # at the start, by user
    unjudged: frozenset[tuple[str, str]] = frozenset()  # owners and parts of which too little is
    # owners and parts that it does not compute for themselves: no error in these is found
    remainders: list[tuple[str, str]] = field(default_factory=list)
    # steps of the server that were not recorded: its parts, summed step by step, end at the first
    server_holes: tuple[Unjudged, ...] = ()

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

    def judged(self) -> Iterator[tuple[str, str, Array]]:
        """Return owner, part and its sums over time, from which active parts are found."""
        for owner, parts in self.parts.items():
            known = {n: sums for n, sums in parts.items() if (owner, n) not in self.unjudged}
            linked = ("link", *accounted(parts)) if "link" in parts else ()  # without waves
            for group in (AROUND, linked, ENVIRONMENT):
                members = [part for part in group if part in known]
                if len(members) > 1:
                    known |= _joined({part: known.pop(part) for part in members})
            if owner in self.tanks:
                for part in ("position_spent", "late_decoding", "withheld"):
                    known.pop(part, None)
                paid = [part for part in (*PAID, *PAID_PORT) if part in parts]
                known |= _joined({part: parts[part] for part in paid})
            for part, found in known.items():
                yield owner, part, found

    @property
    def findings(self) -> list[Finding]:
        """Return the result of the passivity criterion for every part."""
        moved, found = self.moved_j, []
        for owner, part, sums in self.judged():
            unjudged = self.server_holes if owner == SERVER else ()
            known = self.time_s < min((hole.start_s for hole in unjudged), default=np.inf)
            stored_j = self.declared_j.get(owner, 0.0)
            balance = Balance(
                self.time_s[known], sums[known], 0.0 * sums[known], stored_j, moved_j=moved
            )
            found.append(balance.judged(owner, part, unjudged, decides=False))
        return found

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


def _joined(members: Sums) -> Sums:
    """Return running sums as the one of their sum, named after all of them."""
    return {"_and_".join(members): sum_of(members.values())}


def _last(sums: Array) -> float:
    return float(sums[-1])
