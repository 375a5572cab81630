# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A position between the counts of an encoder.

A count that jumps once in a frame is a wave of sqrt(2b) q/T that nobody sent, and its energy would
have to be paid for. So the position follows a velocity, and is kept within one count q of what was
measured: it never drifts away. With e the position measured less the one expected::

    x^ <- x^ + xd^ h + ALPHA e                 within x +- q

xd^ is the device's own velocity; where that is no more than the last jump of its counts,
xd^ <- xd^ + BETA e/h instead (an alpha-beta tracker), and the force takes that one, too. The count
is the smallest step seen; below ``LEAST_M`` a position counts as exact and is left alone.

Equations: docs/theory.md 17.6.
"""

from pmwvc_core.numeric import Flag, Value, absolute, maximum, minimum, truth, where
from pmwvc_core.state import Stateful

ALPHA = 0.3
BETA = ALPHA * ALPHA / (2.0 - ALPHA)
LEAST_M = 1e-7
UNKNOWN_M = 1.0  # a count before any step was seen
ROUNDING = 1e-6


class BetweenCounts(Stateful):
    """See the module.

    Attributes
    ----------
    dx
        Change of the position over the last tick [m].
    """

    SIGNALS = "_x dx _xd"
    MEMORY = "_seen _still_s _count _exact"

    def __init__(self, tick_s: float) -> None:
        self._tick_s = tick_s
        self._x: Value = 0.0
        self.dx: Value = 0.0
        self._xd: Value = 0.0  # followed
        self._seen: Value = 0.0  # position measured last
        self._still_s: Value = 0.0  # since the last count
        self._count: Value = UNKNOWN_M
        self._exact = False  # on every axis, in every run

    def place(self, x: Value) -> None:
        """Begin at a position."""
        self._x = self._seen = x

    def step(self, x: Value, xd: Value) -> Value:
        """Take what was measured after a tick; return the velocity for the force [m/s].

        Parameters
        ----------
        x, xd
            Position [m] and velocity [m/s].
        """
        before = self._x
        if self._exact:
            self._x, self.dx = x, x - before
            return xd
        jump, self._seen = x - self._seen, x
        step = absolute(jump)
        self._count = where((step > 0.0) & (step < self._count), step, self._count)
        exact = (self._count < LEAST_M) | (self._count >= UNKNOWN_M)
        self._exact = truth(self._count < LEAST_M)
        h = self._tick_s
        rough: Flag = (absolute(xd * h - jump) <= ROUNDING * step) & (exact ^ True)
        expected = before + where(rough, self._xd, xd) * h
        count = where(exact, 0.0, self._count)
        error = x - expected
        half = 0.5 * count
        error = error - maximum(minimum(error, half), -half)
        self._still_s = where(step > 0.0, h, self._still_s + h)
        fastest = count / self._still_s
        followed = maximum(minimum(self._xd + (BETA / h) * error, fastest), -fastest)
        self._xd = where(rough, followed, xd)
        self._x = maximum(minimum(expected + ALPHA * error, x + count), x - count)
        self.dx = self._x - before
        return self._xd
