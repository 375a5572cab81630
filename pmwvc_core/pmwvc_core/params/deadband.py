# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the perceptual deadband of a sender."""

from dataclasses import dataclass

from pmwvc_core.params.fields import IsNot, Validated, parameter


@dataclass(frozen=True)
class DeadbandParams(Validated):
    """Packets left out where nothing changed that could be felt (strict channel only)."""

    kind: str = parameter(
        "none",
        ("none", "weber"),
        "weber: no packet while the wave differs by less than ratio from the one sent last; "
        "needs channel = strict",
    )
    ratio: float = parameter(
        0.1, "> 0 and <= 1", "difference that is not felt, of the wave sent last"
    )
    longest_s: float = parameter(
        0.024,
        "> 0 and <= 1 s",
        "longest time that a packet stands for; below the silence time safety.timeout_s",
    )

    is_on = IsNot("kind", "none")  # whether packets are left out

    def problem(self, *, strict: bool, timeout_s: float) -> str:
        """Return why it cannot be used, "" where it can: on the strict channel or another, and
        where silence begins after ``timeout_s`` [s].
        """
        if not self.is_on:
            return ""
        if not strict:
            return (
                f"kind = {self.kind}: needs channel = strict; a packet of the others "
                "stands for a fixed time"
            )
        if self.longest_s >= timeout_s:
            return (
                f"longest_s = {self.longest_s:g}: must be < safety.timeout_s = {timeout_s:g} s, "
                "or the receiver counts the sender as silent"
            )
        return ""
