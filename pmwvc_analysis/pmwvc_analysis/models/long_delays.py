# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Loops with long delays: how many eigenvalues are outside a circle (argument principle).

With Z the shift by a hyperperiod and H(Z) what is sent of what comes in, at wires with delays q,
the eigenvalues of the loop are the zeros of det(I - L(Z)), L(Z) = H(Z) diag(Z^-q). Outside |Z| = r
those are as many as the poles of H there less the turns of det(I - L) along the circle. Z^-q turns
fast and evenly, H slowly. So of the eigenvalues l of L

    arg(1 - l) = arg(-l) + arg(1 - 1/l)    where |l| > 1,

with phase(l) = phase(h) - q theta from a grid that is fine enough for H: the work does not grow
with q. Only where an |l| passes 1 the grid is refined.

Only the delay once around counts, as a user's clock may be shifted against the server's: whole
hyperperiods of a user are those of the direction with fewer packets. States that are not read
(where a device or the object is) are left out: they do not go round.
"""

import math

import numpy as np

from pmwvc_analysis.models.linearize import Linear
from pmwvc_analysis.models.loop import LinearLoop, System, held, put_in
from pmwvc_analysis.models.response import placed, reduced
from pmwvc_core.controllers.library import has_waves
from pmwvc_core.errors import PmwvcError
from pmwvc_core.numeric import Array, Complex, Flags, Integers

LARGEST_DENSE = 80  # packets under way up to which all of them are states of one matrix
ROUNDING = 1e-9  # of ln(radius): beyond it is growth
DOUBLE = 1e-5  # the same where rigid motions are double eigenvalues, which rounding splits
BEYOND = 1e-9  # ln(radius) of a circle that motions with eigenvalue 1 are inside of
FINE = 1e-7  # relative, of ln(radius)
POINTS = 250
LOWEST = 1e-8  # [rad]
PER_TURN, MOST = 10, 200_000  # points for each turn of a difference of delays, and in all
WIDTHS = np.array([0.0, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0])  # of a pole, where points are added
SECTIONS = 15  # of an interval in which |L| passes 1, each into eight parts
PARTS = np.linspace(0.0, 1.0, 9)[:, np.newaxis]
LOG_RADIUS_STEP = 1e-13  # how far a circle is moved off a pole that lies on it


def with_shifted_clocks(loop: LinearLoop) -> tuple[LinearLoop, Flags]:
    """Return a loop with whole hyperperiods of delay in one direction of each user, and which of
    its wires those are.
    """
    delays, long = loop.delays.copy(), np.zeros(len(loop.delays), dtype=np.bool_)
    for user in range(1, len(loop.scenario.users) + 1):
        few, many = sorted((loop.ways == way for way in (user, -user)), key=np.count_nonzero)
        whole = int(delays[many].min()) if many.any() else 0
        delays[many], delays[few] = delays[many] - whole, delays[few] + whole
        long |= few
    return loop._replace(delays=delays), long


def is_long(loop: LinearLoop) -> bool:
    """Tell whether more packets are under way than there should be states, more where several
    signals of a hyperperiod go round: circles take longer than eigenvalues.
    """
    shifted, long = with_shifted_clocks(loop)
    signals = max(np.count_nonzero(long) / len(loop.scenario.users), 1.0)
    return int(shifted.delays[long].sum()) > LARGEST_DENSE * math.sqrt(signals)


class Long:
    """Loops of several runs that are open where packets are under way for long."""

    def __init__(self, loop: LinearLoop) -> None:
        shifted, long = with_shifted_clocks(loop)
        brief = Linear(shifted._replace(delays=np.minimum(shifted.delays, 1)))
        rigid = brief.quotient[1]
        late = put_in(shifted)
        long = long[shifted.delays > 0]
        whole = held(late, ~long)
        n, wires = len(whole.states), len(whole.sources)
        rows = np.concatenate([whole.matrix[:, :n], whole.matrix[:, n + whole.sources]], axis=1)
        _, squares = reduced(rows[:, :, : n + wires], placed(whole.states))
        self.loop, self.ticks, self.motions = loop, loop.ticks, int(rigid[0])
        self.count = len(brief.states) + int((shifted.delays - 1).clip(0).sum())
        pairs = zip(squares, rigid.tolist(), strict=True)
        self.loci = [Loci(square, whole.delays, motions) for square, motions in pairs]

    @property
    def limits(self) -> list[float]:
        """ln(radius) of every run beyond which it grows."""
        read = not has_waves(self.loop.scenario.controller)  # positions, too
        return [DOUBLE if read and each.at_one > 1 else ROUNDING for each in self.loci]

    def radii(self) -> Array:
        """Return every run's spectral radius over the hyperperiod, 1 where rounding hides more."""
        found = np.array([each.log_radius() for each in self.loci])
        return np.exp(np.where((found > 0.0) & (found <= self.limits), 0.0, found))

    def largest(self) -> complex:
        """Return the longest eigenvalue of the first run."""
        log_r = self.loci[0].log_radius()
        angle = self.loci[0].angle_at(log_r - abs(log_r) * 1e-6)
        return complex(np.exp(log_r + 1j * angle))

    def stable(self) -> Flags:
        """Tell of every run whether it is stable."""
        pairs = zip(self.loci, self.limits, strict=True)
        return np.array([each.outside(limit) == 0 for each, limit in pairs])


class Loci:
    """One loop: ``square`` is [A, B; C, D] with wires of ``delays`` (> 0) as inputs and outputs.
    ``at_one`` of its eigenvalues are 1 by a rigid motion; they do not count. PmwvcError where
    delays differ by so much that the grid would be too large.
    """

    def __init__(self, square: Array, delays: Integers, motions: int) -> None:
        n = len(square) - len(delays)
        kept, rows = reduced(square[np.newaxis], np.zeros(n, dtype=np.bool_))
        self._system = System(rows[0], len(kept))
        ones = int(np.sum(np.delete(np.diag(square)[:n], kept) == 1.0))
        self.at_one = max(motions - ones, 0)
        self._least, self._longest = int(delays.min()), int(delays.max())
        self._more = delays - self._least
        self._poles = self._system.poles()
        turns = int(self._longest - self._least)
        if turns * PER_TURN > MOST:
            raise PmwvcError(
                f"delays of the users differ by {turns} hyperperiods, more than "
                f"{MOST // PER_TURN}: there is no answer for these"
            )
        even = np.linspace(0.0, np.pi, max(POINTS, PER_TURN * turns))
        self._grid = np.concatenate([even, np.geomspace(LOWEST, np.pi, POINTS)])

    @property
    def size(self) -> tuple[int, int]:
        """Number of signals that go round, and of states of H."""
        return len(self._more), self._system.n

    def outside(self, log_r: float) -> int:
        """Return how many eigenvalues of the loop are longer than exp(log_r)."""
        try:
            _, turned = self._along(log_r)
        except np.linalg.LinAlgError:
            return self.outside(log_r + LOG_RADIUS_STEP)
        poles = int(np.count_nonzero(np.abs(self._poles) > math.exp(log_r)))
        return poles - round(float(turned.sum()) / np.pi) - (self.at_one if log_r < 0.0 else 0)

    def log_radius(self) -> float:
        """Return ln of the length of the longest eigenvalue."""
        least = -600.0 / self._longest
        low, high, step = BEYOND, BEYOND, 1e-6
        if self.outside(BEYOND) == 0:
            while self.outside(low) <= 0:
                if low <= least:
                    return least
                high, low, step = low, max(low - step, least), 4.0 * step
        else:
            while self.outside(high) > 0:
                low, high, step = high, high + step, 4.0 * step
        while high - low > FINE * max(abs(low), abs(high), 1e-6):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.outside(middle) > 0 else (low, middle)
        return 0.5 * (low + high)

    def angle_at(self, log_r: float) -> float:
        """Return the angle of an eigenvalue just outside the circle: where it turns fastest."""
        angle, turned = self._along(log_r)
        best = int(np.argmin(turned / np.diff(angle)))
        return float(0.5 * (angle[best] + angle[best + 1]))

    def _along(self, log_r: float) -> tuple[Array, Array]:
        """Return angles of the upper half of a circle, and by how much det(I - L) turns between
        them. From either end of an interval in which an |L| passes 1 on, the first such place is
        two angles between which nothing turns.
        """
        width = np.maximum(np.abs(np.abs(self._poles) - math.exp(log_r)), 1e-9)
        angle = np.unique(np.append(self._grid, self._system.angles_near(width, WIDTHS)))
        angle = angle[(angle >= 0.0) & (angle <= np.pi)]
        edge, values = math.exp(self._least * log_r), self._values(angle, log_r)
        longer = np.abs(values) > edge
        apart = np.abs(values[:-1, :, np.newaxis] - values[1:, np.newaxis])
        after = np.take_along_axis(longer[1:], np.argmin(apart, axis=2), axis=1)
        change, count = (longer[:-1] != after).any(axis=1), longer.sum(axis=1)
        begin = np.concatenate([angle[:-1][change], angle[1:][change]])
        end, rows = np.roll(begin, len(begin) // 2), range(len(begin))
        begun = np.concatenate([count[:-1][change], count[1:][change]])
        for _ in range(SECTIONS):
            points = begin + PARTS * (end - begin)  # (parts, intervals), both ends as well
            inside = np.abs(self._values(points[1:-1].ravel(), log_r)) > edge
            same = inside.sum(axis=1).reshape(len(PARTS) - 2, len(begin)) == begun
            steps = np.argmin(np.vstack([same, np.zeros_like(begun, dtype=np.bool_)]), axis=0)
            begin, end = points[steps, rows], points[steps + 1, rows]
        angle = np.unique(np.concatenate([angle, begin, end]))
        values = self._values(angle, log_r)
        longer, count = np.abs(values) > edge, np.sum(np.abs(values) > edge, axis=1)
        late = values * np.exp(-self._least * (log_r + 1j * angle))[:, np.newaxis]
        within = 1.0 - np.where(longer, 1.0 / np.where(longer, late, 1.0), late)
        slowly = np.diff(np.angle(np.prod(np.where(longer, -values, 1.0), axis=1)))
        slowly = (slowly + np.pi) % (2.0 * np.pi) - np.pi
        turned = slowly + np.diff(np.angle(within).sum(axis=1))
        turned -= self._least * np.diff(angle) * count[1:]
        return angle, np.where(count[1:] == count[:-1], turned, 0.0)

    def _values(self, angle: Array, log_r: float) -> Complex:
        """Return the eigenvalues of L Z^q, q the least delay, ``(points, m)``."""
        turned = log_r + 1j * angle
        found = self._system.response(np.exp(turned))
        if found.shape[-1] == 1:
            return np.asarray(found[:, :, 0])
        late = np.exp(-np.multiply.outer(turned, self._more))
        return np.asarray(np.linalg.eigvals(found * late[:, np.newaxis, :]))
