# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The random streams of a link's effects: every packet has its own numbers, by its count.

Number i of packet n of an effect is element (n - 1) % 1024 of the generator of numpy with the seed
``(*seed, crc32(name), 256 + i, (n - 1) // 1024)``; of an extra copy c, and of every packet of a
plug-in, element i of that with the seed ``(*seed, crc32(name), n, c)``.
"""

import zlib
from collections.abc import Sequence

import numpy as np

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
        block, place = divmod(fate.number - 1, BLOCK)
        held = self._blocks.get(index)
        if held is None or held[0] != block:
            rng = np.random.default_rng((*self._key, OWN + index, block))
            held = self._blocks[index] = block, rng.random(BLOCK).tolist()
        return held[1][place]

    def each(self, fate: Fate, index: int = 0) -> float:
        """Return a number of a packet or copy from a generator of its own."""
        stream = np.random.default_rng((*self._key, fate.number, fate.copy))
        return float(stream.random(index + 1)[index])
