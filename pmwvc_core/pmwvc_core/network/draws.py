# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The random numbers of a link, and chains that correlate them. Equations: docs/links.md.

Every packet draws the same four numbers (lost?, copied?, jitter, jitter of the copy) whatever the
settings: the n-th packet meets the same luck under any of them. Number i of packet n of any other
effect is element (n - 1) % 1024 of the generator of numpy with the seed ``(*seed, crc32(name), 256
+ i, (n - 1) // 1024)``; of an extra copy c, and of every packet of a plug-in, element i of that
with the seed ``(*seed, crc32(name), n, c)``. So an effect changes the numbers of no other one.

Correlated numbers keep their marginal distribution, by a Gaussian copula: a chain z of standard
normal numbers, z' = rho z + sqrt(1 - rho^2) e, keeps its distribution; its probability Phi(z) is
evenly spread over [0, 1) whatever rho.
"""

import math
import zlib
from collections.abc import Sequence

import numpy as np

from pmwvc_core.network.distributions import STANDARD_NORMAL, normal
from pmwvc_core.network.in_flight import Fate

BLOCK = 1024
OWN = 256  # keeps the seeds of blocks apart from those of packets
TOGETHER = 256  # packets whose four numbers are drawn together
BELOW_ONE = 1.0 - 2.0**-53


class Draws:
    """The numbers in [0, 1) of one link, of its effects by name."""

    def __init__(self, seed: int | Sequence[int]) -> None:
        self._seed = (seed,) if isinstance(seed, int) else tuple(seed)
        self._rng = np.random.default_rng(seed)
        self._fours: list[list[float]] = []  # of the next packets, backwards
        self._blocks: dict[tuple[str, int], tuple[int, list[float]]] = {}
        self._chains: dict[str, float] = {}

    def four(self) -> list[float]:
        """Return the four numbers of the next packet."""
        if not self._fours:
            self._fours = self._rng.random((TOGETHER, 4)).tolist()[::-1]
        return self._fours.pop()

    def of(self, name: str, fate: Fate, index: int = 0) -> float:
        """Return a number of a packet or copy."""
        return self.each(name, fate, index) if fate.copy else self.nth(name, fate.number, index)

    def nth(self, name: str, count: int, index: int = 0) -> float:
        """Return a number of the count-th packet, or of what happens for the count-th time."""
        block, row = divmod(count - 1, BLOCK)
        held = self._blocks.get((name, index))
        if held is None or held[0] != block:
            rng = np.random.default_rng((*self._seed, _key(name), OWN + index, block))
            held = self._blocks[name, index] = block, rng.random(BLOCK).tolist()
        return held[1][row]

    def each(self, name: str, fate: Fate, index: int = 0) -> float:
        """Return a number of a packet or copy from a generator of its own."""
        rng = np.random.default_rng((*self._seed, _key(name), fate.number, fate.copy))
        return float(rng.random(index + 1)[index])

    def correlated(self, name: str, fate: Fate, u: float, rho: float) -> float:
        """Return an evenly spread number that depends on that of the packet before with a
        correlation rho of [0, 1); u is the random number of this packet or copy alone.
        """
        if rho == 0.0:
            self._chains.pop(name, None)
            return u
        z = normal(u)
        if (before := self._chains.get(name)) is not None:
            z = rho * before + math.sqrt(1.0 - rho * rho) * z
        if not fate.copy:  # the next one does not depend on a copy's
            self._chains[name] = z
        return min(STANDARD_NORMAL.cdf(z), BELOW_ONE)


def _key(name: str) -> int:
    return zlib.crc32(name.encode())
