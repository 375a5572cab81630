# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Random linear time-invariant links with delay, made of parts that have nothing to do with the
product: what they do is worked out from the parts alone, on the real axis s > 0.

Each end is a junction: a constant matrix of norm at most 1 that scatters waves between its outer
port, its delay lines and its reactive one-ports (a spring, a mass, or either behind a loss), whose
reflection is r (a - s)/(a + s) with r of -1 to 1. So an end is passive, and in general neither
reciprocal nor symmetric. Between the ends run lines with delays of their own; the round trip tau
is the shortest way there and back::

    outer port, lines out  =  S_end(s) (outer port, lines in)
    line i                 :  e^(-s T_i)

The far port meets a wall (velocity zero) or nothing (force zero): its reflection is +1 or -1. The
near port's impedance is b (1 + Gamma)/(1 - Gamma).
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
WALL, FREE = 1.0, -1.0
LINES, PARTS = 4, 5  # at most


class End(NamedTuple):
    """A junction with one-ports: signs and losses r, and corners a [1/s]."""

    junction: Array  # (1 + lines + parts, ...) of outer port, lines, parts
    losses: Array  # (parts,)
    corners: Array  # (parts,)

    def scattering(self, s: float) -> Array:
        """Return the matrix between the outer port and the lines."""
        parts = len(self.losses)
        inner = len(self.junction) - parts
        own = np.diag(self.losses * (self.corners - s) / (self.corners + s))
        (oo, oi), (io, ii) = (
            np.split(rows, [inner], axis=1) for rows in np.split(self.junction, [inner])
        )
        return np.asarray(oo + oi @ own @ np.linalg.solve(np.eye(parts) - ii @ own, io))


@dataclass(frozen=True)
class Link:
    """Two ends and the lines between them: delays out and back [s]."""

    near: End
    far: End
    out_s: Array
    back_s: Array
    impedance: float  # b [N s/m], to which the waves at the near port refer

    @property
    def round_trip_s(self) -> float:
        """The shortest way there and back."""
        return float(self.out_s.min() + self.back_s.min())

    def impedance_at(self, s: float, far: float) -> float:
        """Return the impedance [N s/m] at the near port; the far port reflects by a number."""
        near, end = self.near.scattering(s), self.far.scattering(s)
        # What the far end returns into its lines, with its outer port closed.
        closed = end[1:, 1:] + np.outer(end[1:, 0], end[0, 1:]) * far / (1.0 - end[0, 0] * far)
        way = np.diag(np.exp(-s * self.back_s)) @ closed @ np.diag(np.exp(-s * self.out_s))
        lines = np.eye(len(way)) - way @ near[1:, 1:]
        gamma = near[0, 0] + near[0, 1:] @ np.linalg.solve(lines, way @ near[1:, 0])
        return float(self.impedance * (1.0 + gamma) / (1.0 - gamma))

    def ratio(self, s: float) -> float:
        """Return Z_wall/Z_free."""
        return self.impedance_at(s, WALL) / self.impedance_at(s, FREE)


def bound(s: float, round_trip_s: float) -> float:
    """Return the largest ratio that a passive link can have, coth^2(s tau/2)."""
    return float(1.0 / np.tanh(0.5 * s * round_trip_s) ** 2)


def wave_variables(round_trip_s: float, impedance: float = 25.0) -> Link:
    """Return matched wave variables: each end passes everything on."""
    swap = End(np.array([[0.0, 1.0], [1.0, 0.0]]), np.zeros(0), np.zeros(0))
    half_s = np.array([0.5 * round_trip_s])
    return Link(swap, swap, half_s, half_s, impedance)


def random_link(rng: np.random.Generator, gain: float = 1.0) -> Link:
    """Return a random link; passive with a ``gain`` of the junctions up to 1."""
    lines = int(rng.integers(1, LINES + 1))
    delays = 10.0 ** rng.uniform(-3.0, 0.0, (2, lines))
    ends = [_end(rng, lines, gain) for _ in range(2)]
    return Link(ends[0], ends[1], delays[0], delays[1], float(10.0 ** rng.uniform(-1.0, 3.0)))


def _end(rng: np.random.Generator, lines: int, gain: float) -> End:
    """Return an end: three in four lossless, half of them near to one that passes on."""
    parts = int(rng.integers(0, PARTS + 1))
    size = 1 + lines + parts
    turned, _ = np.linalg.qr(rng.normal(size=(size, size)))
    if rng.random() < 0.5:
        straight = np.eye(size)
        straight[[0, 1]] = straight[[1, 0]]
        near, _ = np.linalg.qr(straight + 0.3 * rng.random() * rng.normal(size=(size, size)))
        turned = near * np.sign(np.sum(near * straight, axis=0))
    loss = 1.0 if rng.random() < 0.75 else rng.uniform(0.3, 1.0)
    losses = rng.choice([-1.0, 1.0], parts) * np.where(
        rng.random(parts) < 0.75, 1.0, rng.uniform(0.0, 1.0, parts)
    )
    return End(gain * loss * turned, losses, 10.0 ** rng.uniform(-1.0, 4.0, parts))
