# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The playout of the strict channel: late packets concealed, no displacement or energy invented.

Segments come in: the integral dU of a wave over a duration dt of its sender, and the energy dJ
that pays for it. They are played in the sender's time p (:mod:`.pace`), up to the end e of the
newest one and beyond it by that one's wave w^. With U(p) the integral up to p, per step h::

    due         = U(min(p, e)) - U(before),    guessed <- guessed + w^ (time beyond e)
    asked       = due + w^ (time beyond e) + mistaken min(h/MEND_S, 1)
    ramp        = mean of what was asked in the last N steps; the rest of it stays ``left``
    free        = received - given - released - discarded - reserve of what is still to be played
    wave        = share ramp/h, shortened to n |wave|^2 h/2 <= E = E0 + free; where nothing is
                  predicted and the reserve in the ramp pays for it, E0 is what is lent by now
    share       <- share (1 - n |wave|^2 h/(4E)) beyond e where n |wave|^2/2 > E/MEND_S: E lasts
                  while the wave fades;   rises by h/MEND_S up to 1 before e
    undelivered <- undelivered + ramp - wave h     made up, but not out of the last TANK_J of E0

n is the ratio of impedances (:mod:`pmwvc_core.law.wave.following`). A late segment settles its
part q = min(c, dt) of the c seconds concealed::

    mistaken <- mistaken + U(e + q) - U(e) - guessed q/c,   guessed <- guessed (1 - q/c)

After an outage that made the ends brake, it stays undelivered. Repayment begins ``SETTLE_S`` after
the last wait, rises within ``rises_s`` whatever energy comes at once, and fades as the clock slows
down, to 0 at 2/3 of its rate. At every step, given + released <= received + E0 (``store_j``), and
U(min(p, e)) + guessed = integral played + left + undelivered + mistaken. Equations: docs/theory.md
17.1, 17.2, 17.3, 17.25, 17.29, 17.30.
"""

import math
from typing import NamedTuple

from pmwvc_core.law.channel.constants import FEW, MEND_S, MOST_J, OUTAGE_S, ROUNDING_S, SETTLE_S
from pmwvc_core.law.channel.pace import NEW, Knot, Pace, dropped, pace_arrive, pace_step, played_to
from pmwvc_core.law.channel.ramp import Asked, Ramp, changed_ramp, ramp_step, resting_ramp
from pmwvc_core.law.vectors import Vector, minus, plus, scaled, shortened, squared, within, zero
from pmwvc_core.law.wave.wave import affordable, repayment, wave_j

SETTLED, AT_ONCE = 1e-15, 0.1  # [sqrt(W) s]: nothing; of ``most_repaid``: need not rise


class Energies(NamedTuple):
    """Energies since the start [J]."""

    received_j: float = 0.0
    given_j: float = 0.0
    released_j: float = 0.0  # used otherwise
    discarded_j: float = 0.0  # given up


class Playout(NamedTuple):
    """See the module; waves [sqrt(W)] and their integrals [sqrt(W) s]."""

    pace: Pace
    knots: list[Knot]  # of the segments
    played: Vector  # of them, as played_j [J]
    played_j: float
    wave: Vector  # what is predicted
    guessed: Vector  # given out beyond the newest segment
    mistaken: Vector  # by how much that fell short of what came
    undelivered: Vector  # arrived, due, and not given out yet
    since_s: float  # since the last wait
    moved: Energies
    raised: float  # n
    ramp: Ramp
    share: float  # of the wave that is given out


class PlayoutParams(NamedTuple):
    """Parameters of a playout."""

    most_repaid: float  # longest wave that makes up what is undelivered [sqrt(W)]
    rises_s: float  # in which it grows so long
    store_j: float  # E0
    keep_j: float = 0.0  # free energy that the hand is asked to fill it up to; below zero: of E0


def resting_playout(rest: Vector, moved: Energies, raised: float = 1.0) -> Playout:
    """Return a playout to which nothing has come, with the energies moved before."""
    knots, ramp = [Knot(0.0, rest, 0.0)], resting_ramp(rest, 1)
    return Playout(NEW, knots, rest, 0.0, rest, rest, rest, rest, 0.0, moved, raised, ramp, 1.0)


def begin(s: Playout) -> Playout:
    """Drop what is in store, undelivered and free, for other segments to come. A debt stays."""
    m = s.moved
    moved = m._replace(discarded_j=m.discarded_j + max(_balance_j(m), 0.0))
    return resting_playout(zero(s.undelivered), moved, s.raised)


def _balance_j(m: Energies) -> float:
    """Return the energy that came and is not given out [J]."""
    return m.received_j - m.given_j - m.released_j - m.discarded_j


def free_j(s: Playout) -> float:
    """Return the energy beyond what segments in store need; below zero: taken from E0 [J]."""
    in_store_j = s.knots[len(s.knots) - 1].reserve_j - s.played_j
    return _balance_j(s.moved) - in_store_j - s.ramp.left.reserve_j


def waiting(s: Playout) -> Vector:
    """Return the integral that has arrived and is not given out [sqrt(W) s]."""
    in_store = minus(s.knots[len(s.knots) - 1].integral, s.played)
    arrived = plus(plus(in_store, s.ramp.left.integral), s.undelivered)
    return minus(plus(arrived, s.mistaken), s.guessed)


def add(
    s: Playout, integral: Vector, energy_j: float, duration_s: float, store_j: float
) -> Playout:
    """Take in a segment [sqrt(W) s], its energy, and the sender's time that it lasts, > 0 [s];
    what it lacks beyond what is free, and E0 lends in its time, is undelivered.
    """
    knots, to, to_j, undelivered = s.knots, s.played, s.played_j, s.undelivered
    guessed, mistaken, late_s = s.guessed, s.mistaken, -s.pace.store_s
    begun, gone, time_s = len(knots) > 1, 0, knots[len(knots) - 1].end_s - max(-late_s, 0.0)
    while gone + 1 < len(knots) and knots[gone + 1].end_s <= time_s + ROUNDING_S:
        gone += 1
    if gone > 0:
        to, to_j = minus(to, knots[gone].integral), to_j - knots[gone].reserve_j
        knots = dropped(knots, gone)
    last, pace = knots[len(knots) - 1], pace_arrive(s.pace, duration_s)
    least_j = squared(integral) * (0.5 / duration_s)
    if least_j - energy_j > max(free_j(s), 0.0) + store_j * (duration_s / MEND_S):
        paid = scaled(integral, math.sqrt(energy_j / least_j))
        undelivered, integral = plus(undelivered, minus(integral, paid)), paid
    reserve_j = last.reserve_j + min(s.raised * least_j, energy_j)
    knots = [*knots, Knot(last.end_s + duration_s, plus(last.integral, integral), reserve_j)]
    if begun and late_s > 0.0:
        settled = scaled(guessed, min(duration_s / late_s, 1.0))
        of_it = scaled(integral, min(late_s / duration_s, 1.0))
        guessed = minus(guessed, settled)
        mistaken = minus(plus(mistaken, of_it), settled)
        to, to_j = played_to(knots, pace.store_s)
        if s.pace.silent_s > OUTAGE_S:
            undelivered = plus(undelivered, mistaken)
            mistaken = zero(mistaken)
    wave = scaled(integral, 1.0 / duration_s)
    moved = s.moved._replace(received_j=s.moved.received_j + energy_j)
    return Playout(
        pace, knots, to, to_j, wave, guessed, mistaken, undelivered, s.since_s, moved, s.raised,
        s.ramp, s.share,
    )  # fmt: skip


def play(s: Playout, h: float, p: PlayoutParams) -> tuple[Playout, Vector]:
    """Return the wave of the next h seconds [sqrt(W)]."""
    if len(s.knots) == 1:
        return s, zero(s.undelivered)
    m, before, before_j, undelivered = s.moved, s.played, s.played_j, s.undelivered
    half_j = 0.5 * h * s.raised  # energy of a wave of 1 sqrt(W)
    pace, skipped_s, beyond_s = pace_step(s.pace, h)
    if skipped_s > 0.0:
        before, before_j = played_to(s.knots, max(s.pace.store_s, 0.0) - skipped_s)
        undelivered = plus(undelivered, minus(before, s.played))
    to, to_j = played_to(s.knots, pace.store_s)
    guess, mended = scaled(s.wave, beyond_s), scaled(s.mistaken, min(h / MEND_S, 1.0))
    wanted = Asked(plus(plus(minus(to, before), guess), mended), to_j - before_j)
    ramp, (asked, paid_j) = ramp_step(s.ramp, wanted)
    wave, free = scaled(asked, 1.0 / h), free_j(s._replace(played_j=to_j, ramp=ramp))
    lends = beyond_s > 0.0 or half_j * squared(wave) > paid_j
    lent_j = p.store_j if lends else min(max(-free_j(s), 0.0), p.store_j)
    power = max(free + lent_j, 0.0) / half_j
    share = min(s.share + h / MEND_S, 1.0)
    if beyond_s > 0.0:
        share, square = s.share, s.share**2 * squared(wave)
        if square > power * h / max(h, MEND_S):
            share *= 1.0 - 0.5 * square / max(power, square)
    since_s = 0.0 if share < 1.0 or pace.silent_s > OUTAGE_S else s.since_s + h
    if share < 1.0 or squared(wave) > power:
        wave = shortened(scaled(wave, share), math.sqrt(power))
        undelivered = plus(undelivered, minus(asked, scaled(wave, h)))
    since = (since_s - SETTLE_S) * (1.0 / p.rises_s)
    if since > 0.0 and not within(undelivered, SETTLED):
        most = max(free - min(p.keep_j, 0.0), 0.0) / half_j
        wish = repayment(undelivered, wave, 0.5 * h * most)
        fades = max(3.0 * pace.ratio - 2.0, 0.0)
        wish = scaled(shortened(wish, p.most_repaid * min(since, 1.0)), fades)
        repaid, _ = affordable(wave, wish, most - squared(wave))
        rises = max(math.sqrt(squared(repaid)) / p.most_repaid, AT_ONCE)
        since_s = min(since_s, SETTLE_S + p.rises_s * rises)
        undelivered = minus(undelivered, scaled(repaid, h))
        wave = plus(wave, repaid)
    spent_j = half_j * squared(wave)
    beyond_j = max(free - spent_j - MOST_J, 0.0) if squared(undelivered) <= FEW**2 else 0.0
    moved = Energies(m.received_j, m.given_j + spent_j, m.released_j, m.discarded_j + beyond_j)
    s = Playout(
        pace, s.knots, to, to_j, s.wave, plus(s.guessed, guess), minus(s.mistaken, mended),
        undelivered, since_s, moved, s.raised, ramp, share,
    )  # fmt: skip
    return s, wave


def ramped(s: Playout, steps: int) -> Playout:
    """Take the mean of so many steps; what is due thereby is given out within ``MEND_S``."""
    if steps == len(s.ramp.asked):
        return s
    ramp, due = changed_ramp(s.ramp, steps)
    return s._replace(ramp=ramp, mistaken=plus(s.mistaken, due))


def take_back(s: Playout, wave: Vector, h: float) -> Playout:
    """Take a wave back that was given out for h seconds and not used [sqrt(W)]."""
    moved = s.moved._replace(given_j=s.moved.given_j - s.raised * wave_j(wave, h))
    undelivered = plus(s.undelivered, scaled(wave, h))
    return s._replace(undelivered=undelivered, moved=moved)


def pass_by(s: Playout, lasted_s: float) -> Playout:
    """Let time go by in which the loop did not step [s]: what was due then stays undelivered."""
    if len(s.knots) == 1:
        return s
    burst_s = SETTLE_S if lasted_s > OUTAGE_S else s.pace.burst_s
    store_s = s.pace.store_s - max(min(lasted_s, s.pace.store_s), 0.0)
    pace = s.pace._replace(store_s=store_s, burst_s=burst_s)
    to, to_j = played_to(s.knots, pace.store_s)
    undelivered = plus(s.undelivered, minus(to, s.played))
    return s._replace(pace=pace, played=to, played_j=to_j, undelivered=undelivered)
