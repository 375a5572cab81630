# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The random numbers of a link's effects: a stream for each, and chains that correlate them.

Every packet has its own numbers, by its count: number i of packet n of an effect is element
(n - 1) % 1024 of the generator of numpy with the seed ``(*seed, crc32(name), 256 + i, (n - 1) //
1024)``; of an extra copy c, and of every packet of a plug-in, element i of that with the seed
``(*seed, crc32(name), n, c)``.

Correlated numbers keep their marginal distribution, by a Gaussian copula: a chain z of standard
normal numbers, z' = rho z + sqrt(1 - rho^2) e, keeps its distribution; its probability Phi(z) is
evenly spread over [0, 1) whatever rho. Equations: docs/links.md.
"""

import math
import zlib
from collections.abc import Sequence

import numpy as np

from pmwvc_core.network.distributions import STANDARD_NORMAL, normal
from pmwvc_core.network.in_flight import Fate

BLOCK = 1024
OWN = 256  # keeps the seeds of blocks apart from those of packets


class Stream:
    """Random numbers in [0, 1) of one effect of the library on one link."""

    def __init__(self, seed: Sequence[int], name: str) -> None:
        self._key = (*seed, zlib.crc32(name.encode()))
        self._blocks: dict[int, tuple[int, list[float]]] = {}

    def __call__(self, fate: Fate, index: int = 0) -> float:
        """Return a number of a packet or copy."""
        if fate.copy:
            return self.each(fate, index)
        block, row = divmod(fate.number - 1, BLOCK)
        held = self._blocks.get(index)
        if held is None or held[0] != block:
            rng = np.random.default_rng((*self._key, OWN + index, block))
            held = self._blocks[index] = block, rng.random(BLOCK).tolist()
        return held[1][row]

    def each(self, fate: Fate, index: int = 0) -> float:
        """Return a number of a packet or copy from a generator of its own."""
        stream = np.random.default_rng((*self._key, fate.number, fate.copy))
        return float(stream.random(index + 1)[index])


BELOW_ONE = 1.0 - 2.0**-53


class Correlated:
    """The chain of one effect: from one packet to the next."""

    def __init__(self) -> None:
        self._z: float | None = None

    def draw(self, u: float, rho: float, *, goes_on: bool = True) -> float:
        """Return an evenly spread number that depends on the one before with a correlation rho of
        [0, 1); u, of [0, 1), is the random number of this packet alone. The next number depends on
        this one if it ``goes_on``: not on that of a copy.
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
