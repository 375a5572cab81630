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
    undelivered <- undelivered + due - wave h    made up out of free energy alone

What is undelivered is made up as fast as free energy lasts for all of it
(:func:`.affordable.repayment`), from ``RETURN_S`` after the last wait on, until which the ends
brake, and not at once: the longest wave that makes it up grows over ``rises_s``.

The reserve of a segment is |dU|^2/(2 dt), what its smoothest wave takes. So ``given <= received``
at every step, and U(p) = integral given out + undelivered: displacement may be late, it is never
lost.

``rate`` is 1 but for what keeps a margin at hand and no more than that (:mod:`.margin`). Where
nothing is at hand p waits: the wave is zero, and whatever comes later is played later. What comes
of an outage is not played but stays undelivered; so does what was due while the loop itself did
not run, what comes as a burst after an outage or with the first packets, and what is at hand
beyond ``LONGEST_S``.

A playout with something undelivered, or that has had too much at hand for long, and has no energy
for it is *short*. The other direction then passes on what it can spare (:meth:`Playout.spared`).

Equations: docs/theory.md 17.1, 17.2, 17.3, 17.19.
"""

from pmwvc_core.numeric import (
    Flag,
    Value,
    absolute,
    anywhere,
    between,
    limit_length,
    maximum,
    minimum,
    root,
    squared,
    where,
)
from pmwvc_core.state import Stateful
from pmwvc_core.wave.affordable import affordable, repayment
from pmwvc_core.wave.margin import LONGEST_WAIT_S, SLACK_S, Margin
from pmwvc_core.wave.segments import Segments

LONGEST_S = 0.3
RETURN_S = 0.1  # after the last wait: nothing is repaid until then
SPARED_J = 1e-4  # free energy below which nothing is caught up
PASSED_S = 0.1  # time constant with which a surplus is passed on
FEW = 5e-4  # [sqrt(W) s] undelivered: no energy is asked for
SETTLED = 1e-15  # [sqrt(W) s] undelivered: nothing
MOST_J = 0.05  # free energy kept where nothing is undelivered: more has no use there


class Playout(Stateful):
    """See the module. Floats for one axis and one run, else arrays ``(..., dof)``.

    Parameters
    ----------
    most_repaid, rises_s
        Longest wave that makes up what is undelivered [sqrt(W)], and the time in which it grows so
        long, while the brake lets go [s].

    Attributes
    ----------
    received_j, given_j, released_j, discarded_j
        Energy that arrived, was given out, was used otherwise, and was given up [J].
    undelivered
        Integral that arrived, was due and is not given out yet [sqrt(W) s].
    margin
        Time that is kept at hand against waits.
    """

    BLOCKS = "margin _segments"
    SIGNALS = "_integral _wave undelivered"
    MEMORY = (
        "received_j given_j released_j discarded_j _played_s _reserve _behind _since_s _burst_s "
        "_begins_s"
    )

    def __init__(self, *, most_repaid: Value, rises_s: float = RETURN_S) -> None:
        self.most_repaid = most_repaid
        self.rises_s = rises_s
        self.received_j: Value = 0.0
        self.given_j: Value = 0.0
        self.released_j: Value = 0.0
        self.discarded_j: Value = 0.0
        self._clear()

    def _clear(self) -> None:
        self.undelivered: Value = 0.0
        self.margin = Margin()
        self._segments = Segments()
        self._played_s: Value = 0.0
        self._integral: Value = 0.0  # at the time played
        self._reserve: Value = 0.0
        self._wave: Value = 0.0  # due in the last step
        self._behind = False
        self._since_s: Value = 0.0  # since the last wait
        self._burst_s: Value = 0.0  # for which what comes may still be of an outage
        self._begins_s = RETURN_S  # for which what comes may have waited for the link

    def begin(self) -> None:
        """Drop what is at hand, undelivered and free; a debt stays."""
        free_j = self.received_j - self.given_j - self.released_j
        self.discarded_j = maximum(self.discarded_j, free_j)
        self._clear()

    @property
    def dry(self) -> Flag:
        """Whether nothing has been at hand for so long that the ends brake."""
        return self.margin.waits

    @property
    def at_hand_s(self) -> Value:
        """Time that could be played without another segment [s]."""
        return self._segments.end_s - self._played_s

    @property
    def waiting(self) -> Value:
        """Integral that has arrived and is not given out: at hand, or undelivered [sqrt(W) s]."""
        return self._segments.integrals[-1] - self._integral + self.undelivered

    @property
    def free_j(self) -> Value:
        """Energy beyond what was given out and what the segments at hand need [J]."""
        balance = self.received_j - self.given_j - self.released_j - self.discarded_j
        return balance - (self._segments.reserve_j - self._reserve)

    @property
    def needed_j(self) -> Value:
        """Free energy that makes up what is undelivered, U, and catches up [J]: |U| |w| + e
        |w|^2/2 for the present wave w and an excess e at hand.
        """
        size = root(squared(self._wave))
        late_s = maximum(self.margin.excess_s, 0.0)
        return SPARED_J + root(squared(self.undelivered)) * size + 0.5 * late_s * size * size

    @property
    def short(self) -> Flag:
        """Whether something is undelivered, or to catch up, and there is less than that."""
        needs = (squared(self.undelivered) > FEW**2) | (self.margin.excess_s > 0.0)
        return needs & (self.free_j < self.needed_j) if anywhere(needs) else needs

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
        if self._segments.end_s:
            self._forget()
            self.margin.arrive(self.at_hand_s)
        self._segments.add(integral, duration_s)

    def step(self, h: float) -> Value:
        """Return the wave of the next ``h`` seconds [sqrt(W)]."""
        if not self._segments.end_s:
            return 0.0 * self._integral
        due = self._advance(h)
        wave = due * (1.0 / h)
        free_j = self.free_j
        power = maximum(free_j, 0.0) * (2.0 / h)
        drawn, self._wave = squared(wave), wave  # twice its power
        beyond = drawn > power
        if beyond is not False and anywhere(beyond):
            wave = where(beyond, limit_length(wave, root(power)), wave)
            drawn = squared(wave)
            self.undelivered = self.undelivered + (due - wave * h)
            self._behind = True
        if self._behind:
            self._since_s = self._since_s + h
            wave = self._repay(wave, power, h)
            drawn = squared(wave)
        self.given_j = self.given_j + drawn * (0.5 * h)
        much = free_j > MOST_J  # it has only become less since
        if much is not False and anywhere(much):
            more = where(squared(self.undelivered) > FEW**2, 0.0, self.free_j - MOST_J)
            self.discarded_j = self.discarded_j + maximum(more, 0.0)
        return wave

    def release(self, most: Value, *, beyond: float = 0.0) -> Value:
        """Return free energy beyond a level, at most so much: the wave can do without it [J]."""
        released = maximum(minimum(self.free_j - beyond, most), 0.0)
        self.released_j = self.released_j + released
        return released

    def spared(self, h: float, *, wanted: Flag) -> Value:
        """Return the part of the free energy that passes on in ``h`` seconds, where it is wanted
        [J]; what is needed here stays.
        """
        if not anywhere(wanted):
            return 0.0
        most = maximum(self.free_j - self.needed_j, 0.0) * min(h / PASSED_S, 1.0)
        return self.release(where(wanted, most, 0.0))

    def take_back(self, wave: Value, h: float) -> None:
        """Take a wave back that was given out for ``h`` seconds and not used [sqrt(W)]."""
        self.given_j = self.given_j - squared(wave) * (0.5 * h)
        self.undelivered = self.undelivered + wave * h
        self._behind = True

    def pass_by(self, lasted_s: float) -> None:
        """Let time go by in which the loop did not step [s]: what was due then stays undelivered,
        and nothing is played later for it.
        """
        if self._segments.end_s:
            self._skip(minimum(self._played_s + lasted_s, self._segments.end_s))
            if lasted_s > LONGEST_WAIT_S:  # what came meanwhile may be read only now
                self._burst_s = RETURN_S

    def _advance(self, h: float) -> Value:
        """Play on; return the integral that is due."""
        newest_s, margin = self._segments.end_s, self.margin
        spare_s = newest_s - self._played_s - h
        outage = margin.watch(spare_s, h)
        waits = margin.waits
        if waits is not False and anywhere(waits):
            self._since_s = where(waits, 0.0, self._since_s)
        most_s = self._most_s(outage, h)
        much = spare_s > most_s
        if much is not False and anywhere(much):
            self._skip(maximum(self._played_s, newest_s - most_s))
        rate, late = margin.rate(h), margin.excess_s > 0.0
        if late is not False and anywhere(late):
            spared = self.free_j > minimum(self.needed_j - SPARED_J, SPARED_J)
            rate = where(late & spared, margin.faster, rate)
        played_s = minimum(self._played_s + rate * h, newest_s)
        integral, reserve = self._at(played_s)
        due = integral - self._integral
        self._played_s, self._integral, self._reserve = played_s, integral, reserve
        return due

    def _most_s(self, outage: Flag, h: float) -> Value:
        """Return how much may be at hand [s]. What an outage kept back may come within the next
        ``RETURN_S`` as a burst: of that no more than a packet. What the first packets bring at
        once would be a lag that lasts: of that no more than frames and steps in any phase need.
        """
        longest_s: Value = LONGEST_S
        if self._begins_s > 0.0:
            self._begins_s -= h
            longest_s = self.margin.time_s + SLACK_S + self._segments.lasted_s + h
        burst = outage | (self._burst_s > 0.0)
        if burst is False or not anywhere(burst):
            return longest_s
        self._burst_s = where(outage, RETURN_S, self._burst_s - h)
        few_s = self.margin.time_s + SLACK_S + where(outage, 0.0, self._segments.lasted_s)
        return where(self._burst_s > 0.0, few_s, longest_s)

    def _at(self, time_s: Value) -> tuple[Value, Value]:
        """Return integral and reserve up to a time, also within a segment."""
        i, ratio = self._segments.place(time_s)
        integrals, reserves = self._segments.integrals, self._segments.reserves
        if not isinstance(i, int):
            return between(integrals, i, ratio), between(reserves, i, ratio)
        before, needed = integrals[i - 1], reserves[i - 1]
        return before + (integrals[i] - before) * ratio, needed + (reserves[i] - needed) * ratio

    def _forget(self) -> None:
        """Drop the segments that every run has played."""
        segments = self._segments
        if played := segments.played(self._played_s):
            self._integral = self._integral - segments.integrals[played]
            self._reserve = self._reserve - segments.reserves[played]
            self._played_s = maximum(self._played_s - segments.forget(played), 0.0)

    def _skip(self, to_s: Value) -> None:
        """Owe what would have been played until then."""
        integral, reserve = self._at(to_s)
        self.undelivered = self.undelivered + (integral - self._integral)
        self._behind = True
        self._played_s, self._integral, self._reserve = to_s, integral, reserve

    def _repay(self, wave: Value, power: Value, h: float) -> Value:
        """Return the wave with what of ``undelivered`` can be made up within a power [2 W]."""
        undelivered = self.undelivered
        since = (self._since_s - RETURN_S) * (1.0 / self.rises_s)
        if not anywhere(since > 0.0):
            return wave
        wish = repayment(undelivered, wave, 0.5 * h * power)
        wish = limit_length(wish, self.most_repaid * maximum(minimum(since, 1.0), 0.0))
        repaid, _ = affordable(wave, wish, power - squared(wave))
        self.undelivered = undelivered = undelivered - repaid * h
        self._behind = anywhere(absolute(undelivered) > SETTLED)
        return wave + repaid
