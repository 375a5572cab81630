# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Number of eigenvalues of a loop with long delays outside a circle (argument principle).

The zeros of det(I - L(Z)), L(Z) = H(Z) diag(Z^-q), outside |Z| = r are as many as the poles of H
there less the windings of the eigenvalues of L around 1 along the circle. A winding is a crossing
of the real axis beyond 1. Z^-q turns fast and evenly, H slowly: with phase(L) = phase(H) - q theta
from a grid that is fine enough for H, the crossings between two points are counted, not looked
for, so that the work does not grow with q. Only where |L| passes 1 the angle is bisected.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from pmwvc_core.errors import PmwvcError
from pmwvc_core.numeric import Array, Complex, Integers

POINTS = 250
WITHIN = 21  # points of an interval with a maximum: it then shrinks to a tenth
LOWEST = 1e-8  # [rad]
PER_TURN = 10  # points for each turn of a difference of delays
MOST = 200_000  # points
WIDTHS = np.array([0.0, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0])  # of a pole, where points are added
SECTIONS = 15  # of an interval, each into eight parts
PARTS = np.linspace(0.0, 1.0, 9)[:, np.newaxis]
BEYOND = 1e-9  # ln(radius) of a circle that motions with eigenvalue 1 are inside of
LOG_RADIUS_STEP = 1e-13  # how far a circle is moved off a pole that lies on it
ON_AXIS = 1e-6  # of a turn
FINE = 1e-7  # relative, of ln(radius)


class System(NamedTuple):
    """x+ = A x + B w, y = C x + D w, once a packet."""

    a: Array
    b: Array
    c: Array
    d: Array

    def poles(self) -> Complex:
        """Return the eigenvalues of A."""
        return np.asarray(np.linalg.eigvals(self.a).astype(complex))

    @property
    def growth(self) -> float:
        """The length of the longest eigenvalue of A; 0 without a state."""
        return float(np.abs(self.poles()).max(initial=0.0))

    def angles_near(self, width: Array, widths: Array) -> Array:
        """Return angles so many widths [rad] before and behind that of every pole."""
        steps = np.multiply.outer(width, np.concatenate([-widths, widths]))
        return np.ravel(np.abs(np.angle(self.poles()))[:, np.newaxis] + steps)

    def response(self, z: Complex) -> Complex:
        """Return y per w ``(points, outputs, inputs)`` at points of the z-plane."""
        resolvent = z[:, np.newaxis, np.newaxis] * np.eye(len(self.a)) - self.a
        driven = np.linalg.solve(resolvent, self.b.astype(np.complex128))
        return np.asarray(self.c @ driven + self.d)


class Loci:
    """The eigenvalues of L along circles, for the system H and the delays q of every input (> 0).

    ``at_one`` eigenvalues of the loop are 1 by a rigid motion; they do not count. PmwvcError where
    delays differ by so much that the grid would be too large.
    """

    def __init__(self, system: System, delays: Integers, at_one: int) -> None:
        self._system, self.at_one = system, at_one
        self._least = int(delays.min())
        self._more = delays - self._least
        self._longest = int(delays.max())
        self._poles = system.poles()
        turns = int(self._more.max())
        if turns * PER_TURN > MOST:
            raise PmwvcError(
                f"delays of the users differ by {turns} hyperperiods, more than "
                f"{MOST // PER_TURN}: there is no answer for these"
            )
        self._even = np.linspace(0.0, np.pi, max(POINTS, PER_TURN * turns))

    @property
    def size(self) -> tuple[int, int]:
        """Number of signals that go round, and of states of H."""
        return len(self._more), len(self._poles)

    def outside(self, log_r: float) -> int:
        """Return how many eigenvalues of the loop are longer than exp(log_r)."""
        angle = self._angles(math.exp(log_r))
        try:
            values = _matched(self._values(angle, log_r))
        except np.linalg.LinAlgError:
            return self.outside(log_r + LOG_RADIUS_STEP)
        windings = sum(
            self._crossings(angle, values[:, locus], log_r) for locus in range(values.shape[1])
        )
        poles = int(np.count_nonzero(np.abs(self._poles) > math.exp(log_r)))
        return poles - round(2.0 * windings) - (self.at_one if log_r < 0.0 else 0)

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

    def angle_at(self, log_r: float) -> float | None:
        """Return the angle of an eigenvalue outside the circle, where there is one."""
        angle = self._angles(math.exp(log_r))
        values = _matched(self._values(angle, log_r))
        size = np.log(np.abs(values)) - self._least * log_r
        phase = np.unwrap(np.angle(values), axis=0) - self._least * angle[:, np.newaxis]
        turns = np.floor(phase / (2.0 * np.pi))
        over = (turns[1:] != turns[:-1]) & (np.maximum(size[1:], size[:-1]) > 0.0)
        at = np.argwhere(over)
        if not len(at):
            return None
        best = max(at.tolist(), key=lambda index: max(size[index[0], index[1]], -1.0))
        return float(0.5 * (angle[best[0]] + angle[best[0] + 1]))

    def _angles(self, r: float) -> Array:
        width = np.maximum(np.abs(np.abs(self._poles) - r), 1e-9)
        near = self._system.angles_near(width, WIDTHS)
        every = [self._even, np.geomspace(LOWEST, np.pi, POINTS), near]
        found = np.unique(np.concatenate(every))
        return np.asarray(found[(found >= 0.0) & (found <= np.pi)])

    def _values(self, angle: Array, log_r: float) -> Complex:
        """Return the eigenvalues of L Z^q, q the least delay, ``(points, m)``."""
        turned = log_r + 1j * angle
        found = self._system.response(np.exp(turned))
        if found.shape[-1] == 1:
            return np.asarray(found[:, :, 0])
        late = np.exp(-np.multiply.outer(turned, self._more))
        return np.asarray(np.linalg.eigvals(found * late[:, np.newaxis, :]))

    def _crossings(self, angle: Array, values: Complex, log_r: float) -> float:
        """Return the signed crossings of the real axis beyond 1, upper half; ends count half."""
        size = np.log(np.maximum(np.abs(values), 1e-300)) - self._least * log_r
        phase = np.unwrap(np.angle(values))
        turn = (phase - self._least * angle) / (2.0 * np.pi)
        level = np.floor(turn)
        for end in (0, -1):
            nearest = round(float(turn[end]))
            if abs(turn[end] - nearest) < ON_AXIS:
                level[end] = nearest - 0.5
        above = size > 0.0
        both = above[1:] & above[:-1]
        total = float(np.sum((level[1:] - level[:-1])[both]))
        change = np.flatnonzero(above[1:] != above[:-1])
        if len(change):
            edge = np.floor(self._edges(angle, values, phase, change, log_r) / (2.0 * np.pi))
            falls = above[change]
            total += float(np.sum(np.where(falls, edge - level[change], 0.0)))
            total += float(np.sum(np.where(falls, 0.0, level[change + 1] - edge)))
        return total

    def _edges(
        self, angle: Array, values: Complex, phase: Array, change: Integers, log_r: float
    ) -> Array:
        """Return the phase of L where |L| passes 1, in each of several intervals."""
        low, high = angle[change], angle[change + 1]
        at_low, at_high = values[change], values[change + 1]
        rising = np.abs(at_high) > np.abs(at_low)
        longer = np.where(rising, at_high, at_low)
        begin = np.where(rising, phase[change + 1], phase[change])
        rows = np.arange(len(low))
        for _ in range(SECTIONS):
            points = low + PARTS * (high - low)  # (parts, intervals), both ends as well
            values_at = at_low + PARTS * (at_high - at_low)
            inner, near = self._values(points[1:-1].ravel(), log_r), values_at[1:-1].ravel()
            nearest = np.argmin(np.abs(inner - near[:, np.newaxis]), axis=1)
            values_at[1:-1] = inner[np.arange(len(inner)), nearest].reshape(-1, len(low))
            values_at[0], values_at[-1] = at_low, at_high
            beyond = np.log(np.maximum(np.abs(values_at), 1e-300)) - self._least * log_r > 0.0
            back = np.argmax((beyond == rising)[1:], axis=0)
            low, high = points[back, rows], points[back + 1, rows]
            at_low, at_high = values_at[back, rows], values_at[back + 1, rows]
        turned = np.angle(np.where(rising, at_high, at_low) * longer.conj())
        return np.asarray(begin + turned - self._least * 0.5 * (low + high))


def _matched(values: Complex) -> Complex:
    """Return eigenvalues ``(points, m)`` in an order in which each goes on to the nearest one."""
    if values.shape[1] == 1:
        return values
    apart = np.abs(values[:-1, :, np.newaxis] - values[1:, np.newaxis, :])
    order = np.arange(values.shape[1])
    found = values.copy()
    for point, distances in enumerate(apart, start=1):
        order = linear_sum_assignment(distances)[1][order]
        found[point] = values[point, order]
    return found


def refined(
    at: Callable[[Array], Array], low: float, high: float, *, rounds: int
) -> tuple[float, float]:
    """Return the largest value between two points, and where; ``at`` is of ``(points,)``."""
    found = -np.inf, low
    for _ in range(rounds):
        points = np.linspace(low, high, WITHIN)
        values = at(points)
        top = int(np.argmax(values))
        found = max(found, (float(values[top]), float(points[top])))
        low, high = points[max(top - 1, 0)], points[min(top + 1, WITHIN - 1)]
    return found
