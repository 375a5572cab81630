# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Correlated random numbers with exact marginals: a Gaussian copula.

A chain z of standard normal numbers, z' = rho z + sqrt(1 - rho^2) e, keeps its distribution; its
probability Phi(z) is evenly spread over [0, 1) whatever rho. Equations: docs/links.md.
"""

import math

from pmwvc_core.network.distributions import STANDARD_NORMAL, normal

BELOW_ONE = 1.0 - 2.0**-53


class Correlated:
    """The chain of one effect: from one packet to the next."""

    def __init__(self) -> None:
        self._z: float | None = None

    def draw(self, u: float, rho: float, *, goes_on: bool = True) -> float:
        """Return an evenly spread number that depends on the one before.

        Parameters
        ----------
        u
            Random number in [0, 1) of this packet alone.
        rho
            Correlation of the chain, [0, 1).
        goes_on
            Whether the next number depends on this one: not on that of a copy.
        """
        if rho == 0.0:
            self._z = None
            return u
        z = normal(u)
        if self._z is not None:
            z = rho * self._z + math.sqrt(1.0 - rho * rho) * z
        if goes_on:
            self._z = z
        return min(STANDARD_NORMAL.cdf(z), BELOW_ONE)
