# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A position between the counts of an encoder.

A count that jumps once in a frame is a wave of sqrt(2b) q/T that nobody sent, and its energy would
have to be paid for. So the position follows a velocity, and is kept within one count q of what was
measured: it never drifts away. With e the position measured less the one expected::

    x^ <- x^ + xd^ h + a e                     within x +- q

xd^ is the device's own velocity, and e counts only beyond half a count (a = ``OWN``). Where that
velocity is no more than the last jump of the counts, xd^ <- xd^ + B e/h instead (an alpha-beta
tracker, a = ``TRACKED``), never more than the counts allow: since the last of them the device has
moved less than one. The force takes that velocity, too.

A count crosses an edge to one side and back. Meanwhile the device is beyond that edge, so a force
that only falls from one count to the next takes more on the way out than it gives on the way back,
but for the tick in which a count is late. So xd^ grows only with a count, in the direction of the
count, and else only falls towards zero.

The work counted is that over a position z beside the true one; ``moved`` is its change. Over x
itself too little is counted: the force rises with the count that overshoots, and the next
difference takes the overshoot back. Over x^ too much, where the device swings about an edge. Over
that edge nothing is, since a swing about it comes back to where it was. So z is ``EDGE`` of the
way from x^ to the edge crossed last, and x itself for ``SLOW_S`` after a jump of several counts:
what is missing there is little beside b xd^2, and in a fast swing x^ is late.

The count is the smallest step seen; below ``LEAST_M`` a position counts as exact and is left
alone.

Equations: docs/theory.md 17.6, 17.9, 17.21.
"""

from pmwvc_core.numeric import Flag, Value, absolute, maximum, minimum, truth, where
from pmwvc_core.state import Stateful

OWN = 0.3
TRACKED = 0.72  # slower, a device swings about the edge of a count; quicker, its force is noise
BETA = 0.2  # likewise the other way round
EDGE = 0.3  # less, and a swing is counted as work; more, and packets lack energy
SLOW_S = 0.1  # since a jump of several counts: for so long the work is that over x
LEAST_M = 1e-7
UNKNOWN_M = 1.0  # a count before any step was seen
ROUNDING = 1e-6


class BetweenCounts(Stateful):
    """See the module.

    Attributes
    ----------
    dx, moved
        Change of the position over the last tick, as the wave has it and as the force's work
        counts it [m].
    """

    SIGNALS = "_x dx _xd moved _off _edge"
    MEMORY = "_seen _still_s _slow_s _count _exact _stepped _rough"

    def __init__(self, tick_s: float) -> None:
        self._tick_s = tick_s
        self._x: Value = 0.0
        self.dx: Value = 0.0
        self.moved: Value = 0.0
        self._xd: Value = 0.0  # followed
        self._off: Value = 0.0  # of the position of the work, from the one measured
        self._edge: Value = 0.0  # position of the edge between two counts that was crossed last
        self._seen: Value = 0.0  # position measured last
        self._still_s: Value = 0.0  # since the last count
        self._slow_s: Value = SLOW_S  # since a jump of several counts
        self._count: Value = UNKNOWN_M
        self._exact = False  # on every axis, in every run
        self._stepped = False  # a count was seen, on any axis, in any run
        self._rough: Flag = False  # a velocity that is the jump of the counts

    def take_as_exact(self) -> None:
        """Take positions as exact from now on, before any step shows it."""
        self._exact = True

    @property
    def counts(self) -> bool:
        """Whether any position may be that of counts."""
        return not self._exact

    @property
    def rough(self) -> Value:
        """The count, where the velocity is the jump of the counts; else zero [m]."""
        return where(self._rough, self._count, 0.0)

    def begin(self, x: Value) -> None:
        """Begin at a position."""
        self._x = self._seen = self._edge = x

    def step(self, x: Value, xd: Value) -> Value:
        """Take what was measured after a tick; return the velocity for the force [m/s].

        Parameters
        ----------
        x, xd
            Position [m] and velocity [m/s].
        """
        before, jump = self._x, x - self._seen
        self._seen = x
        if self._exact:
            self._x, self.dx, self.moved = x, x - before, jump
            return xd
        h, step = self._tick_s, absolute(jump)
        self._count = where((step > 0.0) & (step < self._count), step, self._count)
        exact = (self._count < LEAST_M) | (self._count >= UNKNOWN_M)
        self._exact = truth(self._count < LEAST_M)
        if not self._stepped and truth(exact):  # what follows would leave it alone
            self._still_s = where(step > 0.0, 0.0, self._still_s + h)
            self._slow_s = where(step > 0.0, 0.0, self._slow_s + h)
            self._x = self._edge = x
            self.dx, self.moved, self._xd = x - before, jump, xd
            return xd
        self._stepped = True
        shown = (step > 0.0) | (absolute(xd) > 0.0)
        is_jump = (absolute(xd * h - jump) <= ROUNDING * step) & (exact ^ True)
        self._rough = rough = (shown & is_jump) | ((shown ^ True) & self._rough)
        expected = before + where(rough, self._xd, xd) * h
        count = where(exact, 0.0, self._count)
        error = x - expected
        half = where(rough, 0.0, 0.5 * count)
        error = error - maximum(minimum(error, half), -half)
        self._still_s = where(step > 0.0, 0.0, self._still_s + h)
        fastest = (count + step) / maximum(self._still_s, h)
        followed = maximum(minimum(self._xd + (BETA / h) * error, fastest), -fastest)
        last = self._xd
        falling = maximum(minimum(followed, maximum(last, 0.0)), minimum(last, 0.0))
        driven = where(jump * followed > 0.0, followed, 0.0)
        self._xd = where(rough, where(step > 0.0, driven, falling), xd)
        found = expected + where(rough, TRACKED, OWN) * error
        self._x = maximum(minimum(found, x + count), x - count)
        self.dx = self._x - before
        self._edge = edge = maximum(minimum(self._edge, x + 0.5 * count), x - 0.5 * count)
        self._slow_s = where(step > 1.5 * count, 0.0, self._slow_s + h)
        slow = rough & (self._slow_s >= SLOW_S)
        off = where(slow, self._x + EDGE * (edge - self._x) - x, 0.0)
        self.moved, self._off = jump + off - self._off, off
        return self._xd
