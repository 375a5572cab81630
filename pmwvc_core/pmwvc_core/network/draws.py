# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The random numbers of a link, chains that correlate them, and losses that remember. How numbers
and equations are: docs/links.md. The n-th packet meets the same luck under any settings.

Correlated numbers keep their marginal distribution, by a Gaussian copula: a chain z of standard
normal numbers, z' = rho z + sqrt(1 - rho^2) e, keeps its distribution; Phi(z) is evenly spread.
"""

import math
import zlib
from collections.abc import Sequence

import numpy as np

from pmwvc_core.network.distributions import STANDARD_NORMAL, normal
from pmwvc_core.network.in_flight import Cause, Fate
from pmwvc_core.params import LinkParams

BLOCK = 1024
OWN = 256  # keeps the seeds of blocks apart from those of packets
TOGETHER = 256  # packets whose four numbers are drawn together
BELOW_ONE = 1.0 - 2.0**-53
STEP, OUTAGE, LENGTH, LOSS = range(4)  # numbers of a hand-over; the last is a packet's


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
        """Return u, evenly spread, correlated by rho of [0, 1) with that of the packet before."""
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


class Losses:
    """The models of loss of one link: Gilbert-Elliott, and around hand-overs, at which the
    delay steps as well. What happens at the k-th hand-over is drawn by k.
    """

    def __init__(self, draws: Draws) -> None:
        self._draws = draws
        self._bad = False

    def by_two_states(self, p: LinkParams, fate: Fate) -> bool:
        """Lose with the probability of the good (first) or bad state; it changes afterwards."""
        changes, loses = (self._draws.of("gilbert_elliott", fate, index) for index in (0, 1))
        lost = loses < (p.ge_bad if self._bad else p.ge_good)
        if changes < (p.ge_r if self._bad else p.ge_p):
            self._bad = not self._bad
        return lost

    def by_hand_over(self, p: LinkParams, fate: Fate, elapsed_ns: int) -> Cause | bool:
        """Tell whether a packet meets an outage, or is lost around a hand-over."""
        draws, elapsed_s = self._draws, elapsed_ns * 1e-9
        count = int(elapsed_s / p.handover_s)
        since_s = elapsed_s - count * p.handover_s
        if count:
            happens, part = (draws.nth("handover", count, index) for index in (OUTAGE, LENGTH))
            low_s, high_s = p.handover_outage_min_s, p.handover_outage_max_s
            if happens < p.handover_outage and since_s < low_s + (high_s - low_s) * part:
                return Cause.OUTAGE
        near = (count > 0 and since_s < p.handover_loss_s) or (
            p.handover_s - since_s <= p.handover_loss_s
        )
        u = draws.of("handover", fate, LOSS)
        return near and u < p.handover_loss

    def step_s(self, p: LinkParams, elapsed_ns: int) -> float:
        """Return the step of the delay since the last hand-over [s]."""
        count = int(elapsed_ns * 1e-9 / p.handover_s)
        if not count:
            return 0.0
        return p.handover_step_s * (2.0 * self._draws.nth("handover", count, STEP) - 1.0)


def gilbert_loss(params: LinkParams) -> float:
    """Return the mean loss of the Gilbert-Elliott model."""
    p, r = params.ge_p, params.ge_r
    return (params.ge_good * r + params.ge_bad * p) / (p + r) if p + r else params.ge_good
