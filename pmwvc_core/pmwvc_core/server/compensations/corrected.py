# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The compensation with its sign corrected, each step for itself, and what cannot be paid carried.

::

    d(n) = [F(n) F(n-1) - F(n)^2]/b                     of this step [W]
    s    = |v|^2 + 2 d(n) + c(n-1)
    v    = sgn(v) sqrt(max(0, s)),   c(n) = min(0, s)   c: debt [W]

so that sum (|u|^2 - |v|^2)/2 = sum F xd + c(N)/2: without debt the port takes what the environment
takes. While there is debt nothing is returned, so the balance only grows. Hence it never falls
below zero where sum F xd never does. It does not hold back an environment that is active itself.
"""

from collections.abc import Mapping, Sequence

from pmwvc_core.numeric import Value, maximum, minimum, squared
from pmwvc_core.server.compensations.interface import Wave
from pmwvc_core.server.compensations.printed import stretched


class Corrected:
    """Take from each wave what late decoding added to it."""

    def __init__(self, users: int, *, period: float) -> None:
        self._half_period = 0.5 * period
        self._debt: list[Value] = [0.0] * users  # c [W]

    @property
    def accounts(self) -> Mapping[str, Value]:
        """``debt``: what later waves still have to pay, all users together (<= 0)."""
        debt: Value = 0.0
        for each in self._debt:
            debt = debt + self._half_period * each
        return {"debt": debt}

    def step(self, waves: Sequence[Wave], stored: Value | None) -> list[Value]:
        """Return the waves made shorter."""
        return [self._changed(wave) for wave in waves]

    def _changed(self, wave: Wave) -> Value:
        left = squared(wave.v) + 2.0 * wave.late + self._debt[wave.user]
        self._debt[wave.user] = minimum(left, 0.0)
        return stretched(wave.v, maximum(left, 0.0))
