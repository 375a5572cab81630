# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The playout of a wave on the strict channel: late packets concealed, no motion lost, and never
more energy than arrived and was declared.

Segments come in: the integral dU of a wave over a duration dt of its sender, and the energy dJ
that pays for it, whatever was lost, repeated or late in between. They are played in the time p of
the sender (:mod:`.pace`), up to the end e of the newest one and, by the wave w^ of that one,
beyond it. With U(p) the integral up to p, even within a segment, per step of length h::

    due         = U(min(p, e)) - U(before),    guessed <- guessed + w^ (time beyond e)
    asked       = due + w^ (time beyond e) + mistaken min(h/MEND_S, 1)
    free        = received - given - released - discarded - reserve of what is still to be played
    wave        = asked/h, shortened to |wave|^2 h/2 <= E0 + free, beyond e to h/SPREAD_S of that;
                  where nothing is predicted or mended, E0 is what was lent before
    undelivered <- undelivered + asked - wave h     made up out of free energy alone

A segment that comes late settles its part q = min(c, dt) of the c seconds concealed::

    mistaken <- mistaken + U(e + q) - U(e) - guessed q/c,   guessed <- guessed (1 - q/c)

What was guessed for longer than the ends take to brake stays undelivered instead. What is
undelivered is made up as fast as free energy lasts for all of it (:func:`.affordable.repayment`),
from ``RETURN_S`` after the last wait on, until which the ends brake, and not at once: the longest
wave that makes it up grows over ``rises_s``.

The reserve of a segment is |dU|^2/(2 dt), what its smoothest wave takes. So given + released <=
received + E0 at every step, whatever is guessed, with one E0 (``store_j``) for the whole session;
and U(min(p, e)) + guessed = integral given out + undelivered + mistaken: displacement may be late,
it is never lost.

A playout with something undelivered and no energy for it is *short*. The other direction then
passes on what it can spare (:meth:`Playout.spared`); E0 is neither passed on nor used to make up.

Equations: docs/theory.md 17.1, 17.2, 17.3, 17.19, 17.25.
"""

from pmwvc_core.numeric import (
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
from pmwvc_core.wave.pace import Pace
from pmwvc_core.wave.segments import Segments

MEND_S = 0.03  # time constant with which what was guessed wrong is made good
SPREAD_S = 0.015  # the energy left for predictions lasts so long at least
RETURN_S = 0.1  # after the last wait: nothing is repaid until then
SPARED_J = 1e-4  # free energy below which a playout with something undelivered is short
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
    store_j
        Initial stored energy E0, for waves that are predicted or corrected [J].

    Attributes
    ----------
    received_j, given_j, released_j, discarded_j
        Energy that arrived, was given out, was used otherwise, and was given up [J].
    undelivered
        Integral that arrived, was due and is not given out yet [sqrt(W) s].
    """

    BLOCKS = "pace _segments"
    SIGNALS = "_integral _wave undelivered _guessed _mistaken"
    MEMORY = "received_j given_j released_j discarded_j _lent_j _reserve _behind _since_s"

    def __init__(
        self, *, most_repaid: Value, rises_s: float = RETURN_S, store_j: Value = 0.0
    ) -> None:
        self.most_repaid = most_repaid
        self.rises_s = rises_s
        self.store_j = store_j
        self.received_j: Value = 0.0
        self.given_j: Value = 0.0
        self.released_j: Value = 0.0
        self.discarded_j: Value = 0.0
        self._lent_j: Value = 0.0  # of E0
        self._clear()

    def _clear(self) -> None:
        self.undelivered: Value = 0.0
        self.pace = Pace()
        self._segments = Segments()
        self._integral: Value = 0.0  # up to what is played
        self._reserve: Value = 0.0
        self._wave: Value = 0.0  # of the newest segment: what is predicted
        self._guessed: Value = 0.0  # given out beyond the newest segment [sqrt(W) s]
        self._mistaken: Value = 0.0  # by which guesses fell short [sqrt(W) s]
        self._behind = False
        self._since_s = 0.0  # since the last wait

    def begin(self) -> None:
        """Drop what is in store, undelivered and free: what comes has nothing to do with it. A
        debt stays.
        """
        self.discarded_j = self.discarded_j + maximum(self._balance_j, 0.0)
        self._clear()

    @property
    def waits(self) -> bool:
        """Whether nothing has come for so long that the other end is told."""
        return self.pace.waits

    @property
    def waiting(self) -> Value:
        """Integral that has arrived and is not given out: in store, or undelivered [sqrt(W) s]."""
        in_store = self._segments.integrals[-1] - self._integral
        return in_store + self.undelivered + self._mistaken - self._guessed

    @property
    def _balance_j(self) -> Value:
        return self.received_j - self.given_j - self.released_j - self.discarded_j

    @property
    def free_j(self) -> Value:
        """Energy beyond what was given out and what the segments in store need; below zero: taken
        from E0 [J].
        """
        return self._balance_j - (self._segments.reserves[-1] - self._reserve)

    @property
    def needed_j(self) -> Value:
        """Free energy that makes up what is undelivered, U, beside the present wave w: |U| |w|
        [J].
        """
        return SPARED_J + root(squared(self.undelivered)) * root(squared(self._wave))

    @property
    def short(self) -> Flag:
        """Whether something is undelivered, and there is less than that."""
        needs = squared(self.undelivered) > FEW**2
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
        segments, pace = self._segments, self.pace
        begun, late_s, braked = segments.end_s > 0.0, -pace.store_s, pace.brakes
        if begun:
            if played := segments.played(segments.end_s - max(pace.store_s, 0.0)):
                self._integral = self._integral - segments.integrals[played]
                self._reserve = self._reserve - segments.reserves[played]
                segments.forget(played)
        pace.arrive(duration_s)
        segments.add(integral, duration_s)
        self._wave = integral * (1.0 / duration_s)
        if begun and late_s > 0.0:
            self._settle(integral, min(late_s / duration_s, 1.0), min(duration_s / late_s, 1.0))
            if braked:
                self._defer(self._mistaken)
                self._mistaken = 0.0 * self._mistaken

    def _settle(self, integral: Value, played: float, settled: float) -> None:
        """Compare a segment, of which a part was played already by prediction, with its part of
        what was guessed.
        """
        guessed = self._guessed * settled
        self._guessed = self._guessed - guessed
        self._mistaken = self._mistaken + integral * played - guessed
        self._integral, self._reserve = self._at(self.pace.store_s)

    def _at(self, store_s: float) -> tuple[Value, Value]:
        """Return integral and reserve up to where so much is in store [s]."""
        segments = self._segments
        i, ratio = segments.place(segments.end_s - max(store_s, 0.0))
        before, needed = segments.integrals[i - 1], segments.reserves[i - 1]
        return (
            before + (segments.integrals[i] - before) * ratio,
            needed + (segments.reserves[i] - needed) * ratio,
        )

    def step(self, h: float) -> Value:
        """Return the wave of the next ``h`` seconds [sqrt(W)]."""
        if not self._segments.end_s:
            return 0.0 * self._integral
        pace = self.pace
        in_store_s = max(pace.store_s, 0.0)
        skipped_s, beyond_s = pace.step(h)
        if skipped_s > 0.0:
            self._skip(in_store_s - skipped_s)
        self._since_s = 0.0 if pace.brakes else self._since_s + h
        integral, reserve = self._at(pace.store_s)
        guess, mended = self._wave * beyond_s, self._mistaken * min(h / MEND_S, 1.0)
        asked = integral - self._integral + guess + mended
        self._integral, self._reserve = integral, reserve
        self._guessed = self._guessed + guess
        self._mistaken = self._mistaken - mended
        predicts = beyond_s > 0.0
        if predicts or anywhere(absolute(mended) > SETTLED):
            self._lent_j = self.store_j
        return self._given(asked, h, max(h, SPREAD_S) if predicts else h)

    def _given(self, asked: Value, h: float, spread_s: float) -> Value:
        """Return the wave that gives out an integral within ``h`` seconds, as far as energy lasts,
        and of what is undelivered what it lasts for as well.
        """
        wave, free_j = asked * (1.0 / h), self.free_j
        power = maximum(free_j + self._lent_j, 0.0) * (2.0 / spread_s)
        drawn = squared(wave)  # twice its power
        beyond = drawn > power
        if beyond is not False and anywhere(beyond):
            wave = where(beyond, limit_length(wave, root(power)), wave)
            drawn = squared(wave)
            self._defer(asked - wave * h)
        if self._behind:
            wave = self._repay(wave, maximum(free_j, 0.0) * (2.0 / h), h)
            drawn = squared(wave)
        self.given_j = self.given_j + drawn * (0.5 * h)
        self._lent_j = minimum(self._lent_j, maximum(0.5 * h * drawn - free_j, 0.0))
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
        self._defer(wave * h)

    def pass_by(self, lasted_s: float) -> None:
        """Let time go by in which the loop did not step [s]: what was due then stays undelivered,
        and nothing is played later for it.
        """
        if self._segments.end_s:
            self.pace.pass_by(lasted_s)
            self._skip(max(self.pace.store_s, 0.0))

    def _defer(self, integral: Value) -> None:
        """Note an integral that was due and not given out [sqrt(W) s]."""
        self.undelivered = self.undelivered + integral
        self._behind = True

    def _skip(self, store_s: float) -> None:
        """Owe what would have been played until so much is in store [s]."""
        integral, reserve = self._at(store_s)
        self._defer(integral - self._integral)
        self._integral, self._reserve = integral, reserve

    def _repay(self, wave: Value, power: Value, h: float) -> Value:
        """Return the wave with what of ``undelivered`` can be made up within a power [2 W]."""
        undelivered = self.undelivered
        since = (self._since_s - RETURN_S) * (1.0 / self.rises_s)
        if since <= 0.0:
            return wave
        wish = repayment(undelivered, wave, 0.5 * h * power)
        wish = limit_length(wish, self.most_repaid * min(since, 1.0))
        repaid, _ = affordable(wave, wish, power - squared(wave))
        self.undelivered = undelivered = undelivered - repaid * h
        self._behind = anywhere(absolute(undelivered) > SETTLED)
        return wave + repaid
