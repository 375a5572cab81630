# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The body of a wall: it never moves.

A wall is the cube nailed down: the same faces and contact laws, no motion.
"""

from pmwvc_core.numeric import Value
from pmwvc_core.state import Stateful


class FixedBody(Stateful):
    """An object that never moves: whatever the force, velocity zero, no energy taken."""

    MEMORY = "x xd"

    def __init__(self) -> None:
        self.x: Value = 0.0
        self.xd: Value = 0.0

    @property
    def kinetic(self) -> Value:
        """Zero."""
        return 0.0

    def configure(self, mass: Value, damping: Value, *, period: float) -> None:
        """Stay."""

    def push(self, force: Value) -> tuple[Value, Value]:
        """Stay."""
        return 0.0 * force, 0.0

    def imbalance(self, velocity: Value, force: Value) -> Value:
        """Return zero: a wall bears any force."""
        return 0.0 * force

    def mobility(self, slope: Value) -> Value:
        """Return zero."""
        return 0.0 * slope

    def drift(self, velocity: Value) -> Value:
        """Stay."""
        return 0.0
