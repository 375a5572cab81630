# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Second-order sections as a block of the linear model; what rows are is said in :mod:`.blocks`.

y = b0 u + s1, s1+ = b1 u - a1 y + s2, s2+ = b2 u - a2 y, one section after the other. Before the
input of a tick is known its output is ``rest() + gain u``.
"""

import numpy as np
from oracle.linear_model.blocks import column

from pmwvc_core.numeric import Array


class Sections:
    """A filter; states of sections of first order are left out.

    Parameters
    ----------
    sos
        Sections ``b0 b1 b2 1 a1 a2``, ``(sections, 6)``.
    prefix
        Of the states' names.
    """

    def __init__(self, sos: Array, prefix: str = "s") -> None:
        self._sections = [[column(c) for c in section] for section in sos]
        self._second = [bool(np.any(s[[2, 5]])) for s in sos]
        self._first = [
            second or bool(np.any(s[[1, 4]])) for second, s in zip(self._second, sos, strict=True)
        ]
        names: list[str] = []
        for place, (first, second) in enumerate(zip(self._first, self._second, strict=True)):
            names += [f"{prefix}{place}1"] * first + [f"{prefix}{place}2"] * second
        self.names = tuple(names)
        self.state: list[Array] = []
        self.gain: Array = np.ones((1, 1))
        for section in self._sections:
            self.gain = self.gain * section[0]

    def rest(self) -> Array:
        """Return what the output of the next tick is without input."""
        old, y = iter(self.state), np.zeros((1, 1))
        for (b0, *_), first, second in zip(self._sections, self._first, self._second, strict=True):
            y = b0 * y + next(old) if first else b0 * y
            if second:
                next(old)
        return y

    def step(self, u: Array) -> Array:
        """Advance all sections by a tick; return the output."""
        old, new = iter(self.state), []
        for (b0, b1, b2, _, a1, a2), first, second in zip(
            self._sections, self._first, self._second, strict=True
        ):
            y = b0 * u + next(old) if first else b0 * u
            if first:
                s2 = next(old) if second else 0.0
                new.append(b1 * u - a1 * y + s2)
            if second:
                new.append(b2 * u - a2 * y)
            u = y
        self.state = new
        return u

    def at_rest(self, u: Array) -> Array:
        """Return the output under a constant input."""
        for b0, b1, b2, _, a1, a2 in self._sections:
            u = u * (b0 + b1 + b2) / (1.0 + a1 + a2)
        return u

    def steady(self, u: Array) -> list[Array]:
        """Return the states under a constant input."""
        found = []
        for (b0, b1, b2, _, a1, a2), first, second in zip(
            self._sections, self._first, self._second, strict=True
        ):
            y = u * (b0 + b1 + b2) / (1.0 + a1 + a2)
            found += [y - b0 * u] if first else []
            found += [b2 * u - a2 * y] if second else []
            u = y
        return found
