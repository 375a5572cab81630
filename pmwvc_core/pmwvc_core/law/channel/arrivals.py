# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What has come in at one end: by channel, what becomes of an accepted packet and which wave it
gives out.

======== ==========================================================================================
plain    the newest wave until a newer one: holding spends energy that did not arrive (App. B)
zeroing  the newest wave for one step, then zero
strict   segments of displacement and energy, played out
======== ==========================================================================================

Equations: docs/theory.md 17.19.
"""

from typing import Any, NamedTuple

from pmwvc_core.law.channel.constants import FEW, OUTAGE_S, REPORTED_S, SETTLE_S
from pmwvc_core.law.channel.packet import Counting, Packet, Silence, counted, noted_packet, usual
from pmwvc_core.law.channel.playout import (
    Energies,
    Playout,
    PlayoutParams,
    add,
    begin,
    free_j,
    pass_by,
    play,
    resting_playout,
)
from pmwvc_core.law.family import Family, never, opened, same
from pmwvc_core.law.vectors import Vector, length, squared, zero

SPARED_J = 1e-4  # free energy below which a playout with something undelivered is short


class ArrivalsParams(NamedTuple):
    """Rules of a receiver."""

    timeout_s: float  # silent at the earliest
    longest: float  # legal wave [sqrt(W)]
    once: bool  # counts a wave
    plays_on: bool  # in a silence: the strict channel
    playout: PlayoutParams


class PlainArrivals(NamedTuple):
    """Of the plain and the zeroing channel. What is older than a peer's first packet is lost."""

    silence: Silence
    wave: Vector  # the newest [sqrt(W)]
    position: Vector  # [m]
    fresh: bool  # not given out yet
    sum_j: float  # of the newest packet
    received_j: float  # by how much the sums have grown


class StrictArrivals(NamedTuple):
    """Of the strict channel."""

    silence: Silence
    playout: Playout
    counting: Counting
    position: Vector  # [m] of the newest packet
    wanted: bool  # the other end lacks energy
    received_j: float  # by how much the sums have grown


def _plays_on(s: Any, h: float, p: Any) -> tuple[Any, Vector]:
    return s, zero(s.position)


def _none_spared(s: Any, h: float, p: Any) -> tuple[Any, float]:
    return s, 0.0


def _no_news(s: Any, p: Any) -> tuple[bool, bool]:
    return False, False


arrive = Family("arrive")  # (s, packet, now_ns, p) -> s: an accepted packet
wave_of = Family("wave_of")  # (s, h, p) -> (s, wave of the next h seconds [sqrt(W)])
# (s, h, p) -> (s, wave of a frame); a playout goes on by itself
answer_of = Family("answer_of", _plays_on)
spare = Family("spare", _none_spared)  # (s, h, p) -> (s, energy that the other end lacks [J])
anew = Family("anew", same)  # (s) -> s: the peer placed its position by the newest packet
idle = Family("idle", same)  # (s, lasted_s) -> s: time went by without steps
raised = Family("raised", same)  # (s, n) -> s: waves move a port of n b
# (s, p) -> what the other end is told: energy is short; nothing is at hand
news = Family("news", _no_news)
waits = Family("waits", never)  # (s) -> no wave is at hand any more: this end brakes


def start_of(
    strict: bool, axes: int, timeout_s: float, period_s: float
) -> PlainArrivals | StrictArrivals:
    """Return arrivals before the first packet, which come every so often [s]."""
    limit_ns, nothing = round(max(timeout_s, 3.0 * period_s) * 1e9), (0.0,) * axes
    silence, counting = Silence(limit_ns, period_s), Counting(nothing, period_s, period_s)
    if strict:
        playout = resting_playout(nothing, Energies())
        return StrictArrivals(silence, playout, counting, nothing, False, 0.0)
    return PlainArrivals(silence, nothing, nothing, False, 0.0, 0.0)


@arrive.member(PlainArrivals)
def _arrive(s: PlainArrivals, packet: Packet, now_ns: int, p: ArrivalsParams) -> PlainArrivals:
    sum_j = packet.energy_j if packet.fresh else max(packet.energy_j, s.sum_j)
    gained_j = 0.0 if packet.fresh else sum_j - s.sum_j
    silence = noted_packet(s.silence, packet.number, now_ns, False)
    received_j = s.received_j + gained_j
    return PlainArrivals(silence, packet.wave, packet.position, True, sum_j, received_j)


@arrive.member(StrictArrivals)
def _segment(s: StrictArrivals, packet: Packet, now_ns: int, p: ArrivalsParams) -> StrictArrivals:
    passed_s = (now_ns - s.silence.accepted_ns) * 1e-9
    counting, goes_on, moved, paid_j, lasted_s = counted(s.counting, packet, passed_s, p.longest)
    silence = noted_packet(s.silence, packet.number, now_ns, packet.waits)
    if goes_on:
        late_s = abs(passed_s - lasted_s)
        silence = usual(silence, packet.period_s, late_s, p.timeout_s)
    playout = s.playout if goes_on else begin(s.playout)
    playout = add(playout, moved, paid_j, lasted_s, p.playout.store_j)
    received_j = s.received_j + paid_j
    return StrictArrivals(silence, playout, counting, packet.position, packet.short, received_j)


@wave_of.member(PlainArrivals)
@answer_of.member(PlainArrivals)
def _wave(s: PlainArrivals, h: float, p: ArrivalsParams) -> tuple[PlainArrivals, Vector]:
    wave = s.wave if s.fresh or not p.once else zero(s.wave)
    return s._replace(fresh=False), wave


@wave_of.member(StrictArrivals)
def _wave_strict(s: StrictArrivals, h: float, p: ArrivalsParams) -> tuple[StrictArrivals, Vector]:
    playout, wave = play(s.playout, h, p.playout)
    return s._replace(playout=playout), wave


def _needed_j(s: Playout, p: PlayoutParams) -> float:
    """Return the free energy that makes up what is undelivered, and fills the store [J]."""
    needed_j = p.keep_j
    if squared(s.undelivered) > FEW**2:
        repaid_j = s.raised * length(s.undelivered) * length(s.wave)
        needed_j = max(needed_j, 0.0) + SPARED_J + repaid_j
    return needed_j


def is_short(s: Playout, p: PlayoutParams) -> bool:
    """Tell whether there is less energy than is needed."""
    return free_j(s) < _needed_j(s, p)


def release(s: Playout, most_j: float, beyond_j: float) -> tuple[Playout, float]:
    """Return free energy beyond a level, at most so much: the wave can do without it [J]."""
    released_j, m = max(min(free_j(s) - beyond_j, most_j), 0.0), s.moved
    return s._replace(moved=m._replace(released_j=m.released_j + released_j)), released_j


def spared(
    s: Playout, h: float, wanted: bool, beyond_j: float, p: PlayoutParams
) -> tuple[Playout, float]:
    """Return what passes on of free energy beyond a level in h seconds, where it is wanted [J]."""
    if not wanted:
        return s, 0.0
    most_j = max(free_j(s) - _needed_j(s, p), 0.0) * min(h / SETTLE_S, 1.0)
    return release(s, most_j, beyond_j)


@spare.member(StrictArrivals)
def _spare(s: StrictArrivals, h: float, p: ArrivalsParams) -> tuple[StrictArrivals, float]:
    playout, energy_j = spared(s.playout, h, s.wanted, 0.0, p.playout)
    return s._replace(playout=playout), energy_j


@opened.member(StrictArrivals)
@anew.member(StrictArrivals)
def _anew_strict(s: StrictArrivals) -> StrictArrivals:
    return s._replace(playout=begin(s.playout))


@raised.member(StrictArrivals)
def _raised(s: StrictArrivals, n: float) -> StrictArrivals:
    return s._replace(playout=s.playout._replace(raised=n))


@idle.member(StrictArrivals)
def _idle_strict(s: StrictArrivals, lasted_s: float) -> StrictArrivals:
    return s._replace(playout=pass_by(s.playout, lasted_s))


@news.member(StrictArrivals)
def _news_strict(s: StrictArrivals, p: ArrivalsParams) -> tuple[bool, bool]:
    return is_short(s.playout, p.playout), s.playout.pace.silent_s > REPORTED_S


@waits.member(StrictArrivals)
def _waits_strict(s: StrictArrivals) -> bool:
    return s.playout.pace.silent_s > OUTAGE_S
