# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The compensation with its sign corrected, each step for itself, and what cannot be paid carried.

::

    d(n) = [F(n) F(n-1) - F(n)^2]/b                     of this step [W]
    s    = |v|^2 + 2 d(n) + c(n-1)
    v    = sgn(v) sqrt(max(0, s)),   c(n) = min(0, s)   c: debt [W]

so that sum (|u|^2 - |v|^2)/2 = sum F xd + c(N)/2: without debt the port takes what the environment
takes. While there is debt nothing is returned, so the balance only grows. Hence it never falls
below zero where sum F xd never does. For several users that holds of all together only, so the
debt is one: what a user cannot pay, all pay, each in proportion to its |v|^2 + 2 d.

It does not hold back an environment that is active itself.
"""

from collections.abc import Mapping, Sequence

from pmwvc_core.numeric import Value, maximum, minimum, squared, where
from pmwvc_core.server.compensations.interface import Wave
from pmwvc_core.server.compensations.printed import stretched


class Corrected:
    """Take from the waves what late decoding added to them."""

    def __init__(self, *, period: float) -> None:
        self._half_period = 0.5 * period
        self._debt: Value = 0.0  # c [W]

    @property
    def accounts(self) -> Mapping[str, Value]:
        """``debt``: what later waves still have to pay (<= 0)."""
        return {"debt": self._half_period * self._debt}

    def step(self, waves: Sequence[Wave], stored: Value | None) -> list[Value]:
        """Return the waves made shorter."""
        own = [squared(wave.v) + 2.0 * wave.late for wave in waves]
        have, debt = 0.0 * self._debt, self._debt
        for left in own:
            have = have + maximum(left, 0.0)
            debt = debt + minimum(left, 0.0)
        self._debt = minimum(have + debt, 0.0)
        share = maximum(have + debt, 0.0) / where(have > 0.0, have, 1.0)
        return [
            stretched(wave.v, maximum(left, 0.0) * share)
            for wave, left in zip(waves, own, strict=True)
        ]
