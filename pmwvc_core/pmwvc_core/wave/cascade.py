# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Second-order sections one after the other, on floats or on arrays ``(runs, dof)``.

Each is in transposed direct form II, at rest at first: y = b0 u + s1, s1+ = b1 u - a1 y + s2,
s2+ = b2 u - a2 y. So before the input of a tick is known its output is already ``rest() + gain
u``: what a loop without delay through the filter needs to be solved.
"""

import math

from pmwvc_core.numeric import Array, Value
from pmwvc_core.state import Stateful


class Cascade(Stateful):
    """A filter given as second-order sections.

    Parameters
    ----------
    sos
        Sections ``b0 b1 b2 1 a1 a2``, ``(sections, 6)`` or ``(sections, 6, runs, 1)``.

    Attributes
    ----------
    gain
        By how much the output follows the input of the same tick.
    y
        Output after the last tick.
    """

    SIGNALS = "y delays"

    def __init__(self, sos: Array) -> None:
        plain = sos.ndim == 2
        self._sections = [
            [*(float(c) if plain else c for c in section[[0, 1, 2, 4, 5]]), 0.0, 0.0]
            for section in sos
        ]
        self.gain: Value = math.prod(section[0] for section in self._sections)
        self.y: Value = 0.0

    def step(self, u: Value) -> Value:
        """Take the input of a tick; return the output."""
        for section in self._sections:
            b0, b1, b2, a1, a2, s1, s2 = section
            y = b0 * u + s1
            section[5] = b1 * u - a1 * y + s2
            section[6] = b2 * u - a2 * y
            u = y
        self.y = u
        return u

    def rest(self) -> Value:
        """Return what the output of the next tick is without input; nothing moves."""
        y: Value = 0.0
        for section in self._sections:
            y = section[0] * y + section[5]
        return y

    def sample(self) -> Value:
        """Return the output after the last tick."""
        return self.y

    @property
    def delays(self) -> list[tuple[Value, Value]]:
        """The state of the sections, s1 and s2 of each."""
        return [(section[5], section[6]) for section in self._sections]

    @delays.setter
    def delays(self, held: list[tuple[Value, Value]]) -> None:
        for section, pair in zip(self._sections, held, strict=True):
            section[5:] = pair
