# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The playout of a wave on the strict channel: never more energy than arrived, no motion lost.

Segments come in: the integral dU of a wave over a duration dt of its sender, and the energy dJ
that pays for it, whatever was lost, repeated or late in between. They are played in the time of
the sender. Per step of length h, with p the time played so far and U(p) the integral up to there,
even within a segment::

    p     <- p + rate h                     never beyond the newest segment
    due    = U(p) - U(p_before)
    free   = received - given - released - discarded - reserve of what is still to be played
    wave   = due/h, shortened to |wave|^2 h/2 <= free
    owed  <- owed + due - wave h            repaid out of free energy alone

What is owed is repaid as fast as free energy lasts for all of it (:func:`.affordable.repayment`),
from ``RETURN_S`` after the last wait on: until then the ends brake.

The reserve of a segment is |dU|^2/(2 dt), what its smoothest wave takes. So ``given <= received``
at every step, and U(p) = integral given out + owed: displacement may be late, it is never lost.

``rate`` is 1. Where nothing is at hand p waits: the wave is zero, and whatever comes later is
played later; it comes back at the rate ``SLOWEST``, which rises to 1 in the time of the wait. Two
such waits make a margin of the shorter one; while less than the margin is at hand the wave is
stretched, which costs nothing. The margin fades over ``FADE_S``. Where for ``WINDOW_S`` more was
at hand than the margin, the wave is played at ``CATCH_UP``, which costs energy and is done out of
free energy only. A wait longer than ``LONGEST_WAIT_S`` is an outage: what comes of it is not
played but owed; so is what is at hand beyond ``LONGEST_S``.

Equations: docs/theory.md 17.1, 17.2, 17.3.
"""

import math
from bisect import bisect_right
from typing import Any

import numpy as np

from pmwvc_core.numeric import (
    Array,
    Flag,
    Value,
    absolute,
    anywhere,
    limit_length,
    maximum,
    minimum,
    root,
    squared,
    where,
)
from pmwvc_core.state import Stateful
from pmwvc_core.wave.affordable import affordable, repayment

SLOWEST = 0.5  # rate while next to nothing is at hand
CATCH_UP = 1.05  # rate while more is at hand than needed
WINDOW_S = 3.0  # the least at hand in one or two of these decides whether to catch up
FADE_S = 10.0
KEPT = math.exp(-WINDOW_S / FADE_S)  # of the margin after a window
SLACK_S = 1.5e-3  # at hand beyond the margin: no reason to catch up
LONGEST_WAIT_S = 0.04  # what a wait counts for at most: longer ones are outages, no jitter
LONGEST_S = 0.3
RETURN_S = 0.1  # after the last wait: nothing is repaid until then
SPARED_J = 1e-4  # free energy below which nothing is caught up
ROUNDING_S = 1e-9  # of times: less is no wait
SETTLED = 1e-15  # [sqrt(W) s] owed: nothing
MOST_J = 0.05  # free energy kept: what is more must not come out years later


class Playout(Stateful):
    """See the module. Floats for one axis and one run, else arrays ``(..., dof)``.

    Parameters
    ----------
    most_repaid
        Longest wave that repays what is owed [sqrt(W)].

    Attributes
    ----------
    received_j, given_j, released_j, discarded_j
        Energy that arrived, was given out, was used otherwise, and was given up [J].
    owed
        Integral that arrived, was due and is not given out yet [sqrt(W) s].
    margin_s
        Time that is kept at hand against waits [s].
    """

    SIGNALS = "_integrals _integral owed"
    MEMORY = (
        "received_j given_j released_j discarded_j margin_s _ends_s _reserves _played_s _reserve "
        "_owes _since_s _ramp_s _back_s _wait_s _waited_s _least_s _least_before_s _window_s"
    )

    def __init__(self, *, most_repaid: Value) -> None:
        self.most_repaid = most_repaid
        self.received_j: Value = 0.0
        self.given_j: Value = 0.0
        self.released_j: Value = 0.0
        self.discarded_j: Value = 0.0
        self._clear()

    def _clear(self) -> None:
        self.owed: Value = 0.0
        self.margin_s: Value = 0.0
        self._ends_s = [0.0]  # of the segments, from the first one kept
        self._integrals: list[Value] = [0.0]  # there
        self._reserves: list[Value] = [0.0]  # energy of the smoothest wave up to there [J]
        self._played_s: Value = 0.0
        self._integral: Value = 0.0  # at the time played
        self._reserve: Value = 0.0
        self._owes = False
        self._since_s: Value = 0.0  # since the last wait
        self._wait_s: Value = 0.0  # of the wait under way
        self._waited_s: Value = 0.0  # longest wait of late
        self._ramp_s: Value = 0.0  # in which the wave comes back after a wait
        self._back_s: Value = 0.0  # for which it has been back
        self._least_s: Value = math.inf  # at hand, in this window and in the last one
        self._least_before_s: Value = math.inf
        self._window_s = 0.0

    def begin(self) -> None:
        """Drop what is at hand, owed and free: what comes has nothing to do with it."""
        self.discarded_j = self.received_j - self.given_j - self.released_j
        self._clear()

    def forget_waits(self) -> None:
        """Keep no margin, as if packets had come evenly for long."""
        self.margin_s = self._waited_s = self._ramp_s = 0.0

    @property
    def dry(self) -> Flag:
        """Whether the last step waited: nothing was at hand for a part of it."""
        return self._wait_s > 0.0

    @property
    def at_hand_s(self) -> Value:
        """Time that could be played without another segment [s]."""
        return self._ends_s[-1] - self._played_s

    @property
    def waiting(self) -> Value:
        """Integral that has arrived and is not given out: at hand, or owed [sqrt(W) s]."""
        return self._integrals[-1] - self._integral + self.owed

    @property
    def free_j(self) -> Value:
        """Energy beyond what was given out and what the segments at hand need [J]."""
        balance = self.received_j - self.given_j - self.released_j - self.discarded_j
        return balance - (self._reserves[-1] - self._reserve)

    def add(self, integral: Value, energy: Value, duration_s: float) -> None:
        """Take a segment in.

        Parameters
        ----------
        integral
            Of the wave over the segment [sqrt(W) s].
        energy
            That came with it [J].
        duration_s
            Time of the sender that it stands for, > 0 [s].
        """
        self.received_j = self.received_j + energy
        if len(self._ends_s) > 1:
            self._forget()
        self._ends_s.append(self._ends_s[-1] + duration_s)
        self._integrals.append(self._integrals[-1] + integral)
        self._reserves.append(self._reserves[-1] + squared(integral) * (0.5 / duration_s))

    def step(self, h: float) -> Value:
        """Return the wave of the next ``h`` seconds [sqrt(W)]."""
        if len(self._ends_s) == 1:
            return 0.0 * self._integral
        due = self._advance(h)
        wave = due * (1.0 / h)
        power = maximum(self.free_j, 0.0) * (2.0 / h)
        needed = squared(wave)
        if anywhere(needed > power):
            wave = where(needed > power, limit_length(wave, root(power)), wave)
            self.owed = self.owed + (due - wave * h)
            self._owes = True
        if self._owes:
            self._since_s = self._since_s + h
            wave = self._repay(wave, power, h)
        self.given_j = self.given_j + squared(wave) * (0.5 * h)
        more = self.free_j - MOST_J
        if anywhere(more > 0.0):
            self.discarded_j = self.discarded_j + maximum(more, 0.0)
        return wave

    def release(self, most: Value, *, beyond: float = 0.0) -> Value:
        """Return free energy beyond a level, at most so much: the wave can do without it [J]."""
        released = maximum(minimum(self.free_j - beyond, most), 0.0)
        self.released_j = self.released_j + released
        return released

    def take_back(self, wave: Value, h: float) -> None:
        """Take a wave back that was given out for ``h`` seconds and not used [sqrt(W)]."""
        self.given_j = self.given_j - squared(wave) * (0.5 * h)
        self.owed = self.owed + wave * h
        self._owes = True

    def _advance(self, h: float) -> Value:
        """Play on; return the integral that is due."""
        newest_s, spare_s = self._ends_s[-1], self.at_hand_s - h
        outage = self._watch(spare_s, h)
        most_s = where(outage, self.margin_s + SLACK_S, LONGEST_S)
        if anywhere(spare_s > most_s):
            self._skip(maximum(self._played_s, newest_s - most_s))
            spare_s = self.at_hand_s - h
        played_s = minimum(self._played_s + self._rate(spare_s, h) * h, newest_s)
        integral, reserve = self._at(played_s)
        due = integral - self._integral
        self._played_s, self._integral, self._reserve = played_s, integral, reserve
        return due

    def _skip(self, to_s: Value) -> None:
        """Owe what would have been played until then."""
        integral, reserve = self._at(to_s)
        self.owed = self.owed + (integral - self._integral)
        self._owes = True
        self._played_s, self._integral, self._reserve = to_s, integral, reserve

    def _watch(self, spare_s: Value, h: float) -> Flag:
        """Learn from waits, and from what lies at hand; tell whether an outage ends here."""
        self._window_s += h
        if self._window_s > WINDOW_S:
            self._window_s = 0.0
            self._least_before_s, self._least_s = self._least_s, math.inf
            self.margin_s, self._waited_s = KEPT * self.margin_s, KEPT * self._waited_s
        self._least_s = minimum(self._least_s, spare_s)
        dry = spare_s < -ROUNDING_S
        over = (self._wait_s > 0.0) & (dry ^ True)
        outage: Flag = False
        if anywhere(over):
            outage = over & (self._wait_s > LONGEST_WAIT_S)
            counts = over & (outage ^ True)
            again = maximum(self.margin_s, minimum(self._wait_s, self._waited_s))
            self.margin_s = where(counts, again, self.margin_s)
            longest = maximum(self._waited_s, self._wait_s)
            self._waited_s = where(counts, longest, self._waited_s)
            self._ramp_s = where(over, minimum(self._wait_s, LONGEST_WAIT_S), self._ramp_s)
            self._back_s = where(over, 0.0, self._back_s)
            self._wait_s = where(over, 0.0, self._wait_s)
        if anywhere(dry):
            self._wait_s = self._wait_s + where(dry, minimum(-spare_s, h), 0.0)
            self._since_s = where(dry, 0.0, self._since_s)
        return outage

    def _rate(self, spare_s: Value, h: float) -> Value:
        """Return how fast the sender's time is played."""
        rate: Value = 1.0
        margin_s = self.margin_s
        returns = self._back_s < self._ramp_s
        if anywhere(returns):
            ratio = self._back_s / where(returns, self._ramp_s, 1.0)
            rate = where(returns, SLOWEST + (1.0 - SLOWEST) * ratio, 1.0)
            self._back_s = self._back_s + h
        kept = margin_s > 0.0
        if anywhere(kept):
            slow = maximum(minimum(spare_s / where(kept, margin_s, 1.0), 1.0), SLOWEST)
            rate = where(kept, minimum(slow, rate), rate)
        ample = minimum(self._least_s, self._least_before_s) > margin_s + SLACK_S
        if anywhere(ample):
            rate = where(ample & (self.free_j > SPARED_J) & (returns ^ True), CATCH_UP, rate)
        return rate

    def _repay(self, wave: Value, power: Value, h: float) -> Value:
        """Return the wave with what of ``owed`` can be repaid within a power [2 W]."""
        owed = self.owed
        if not anywhere(self._since_s > RETURN_S):
            return wave
        wish = repayment(owed, wave, 0.5 * h * power)
        wish = where(self._since_s > RETURN_S, limit_length(wish, self.most_repaid), 0.0 * wish)
        repaid, _ = affordable(wave, wish, power - squared(wave))
        self.owed = owed = owed - repaid * h
        self._owes = anywhere(absolute(owed) > SETTLED)
        return wave + repaid

    def _at(self, time_s: Value) -> tuple[Value, Value]:
        """Return integral and reserve up to a time."""
        ends, integrals, reserves = self._ends_s, self._integrals, self._reserves
        if not isinstance(time_s, np.ndarray):
            i = min(bisect_right(ends, time_s), len(ends) - 1)
            ratio = (time_s - ends[i - 1]) / (ends[i] - ends[i - 1])
            before, needed = integrals[i - 1], reserves[i - 1]
            return (
                before + (integrals[i] - before) * ratio,
                needed + (reserves[i] - needed) * ratio,
            )
        times = np.array(ends)
        index = np.clip(np.searchsorted(times, time_s, side="right"), 1, len(ends) - 1)
        ratio = (time_s - times[index - 1]) / (times[index] - times[index - 1])
        return _between(integrals, index, ratio), _between(reserves, index, ratio)

    def _forget(self) -> None:
        """Drop the segments that every run has played; the rest begins at zero."""
        played = self._played_s
        first = float(np.min(played)) if isinstance(played, np.ndarray) else played
        done = bisect_right(self._ends_s, first + ROUNDING_S) - 1
        if done < 1:
            return
        time_s, integral = self._ends_s[done], self._integrals[done]
        reserve = self._reserves[done]
        self._ends_s = [each - time_s for each in self._ends_s[done:]]
        self._integrals = [each - integral for each in self._integrals[done:]]
        self._reserves = [each - reserve for each in self._reserves[done:]]
        self._played_s = maximum(played - time_s, 0.0)
        self._integral = self._integral - integral
        self._reserve = self._reserve - reserve


def _between(values: list[Any], index: np.typing.NDArray[np.intp], ratio: Array) -> Array:
    """Interpolate values at the ends of segments, each run at its own time."""
    stacked = np.stack(np.broadcast_arrays(*values, ratio)[:-1])
    at = np.broadcast_to(index, stacked.shape[1:])[None]
    before = np.take_along_axis(stacked, at - 1, axis=0)[0]
    after = np.take_along_axis(stacked, at, axis=0)[0]
    found: Array = before + (after - before) * ratio
    return found
