# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What one end says to the other, and its sender: packets with running sums, and the deadband that
leaves some of them out. A packet is what the laws see of a message.

::

    integral <- integral + w T          energy <- energy + |w|^2 T/2
    held back where  |w - w_sent| <= ratio |w_sent|

A wave that differs too little from the one sent last to be felt needs no packet of its own
(Hinterseer et al., 2008), unless the next packet would then stand for more than the longest time
allowed. The packet after it stands for the time of both and carries their mean. Sums make every
packet contain all earlier ones.

Equations: docs/theory.md 17.11.
"""

from typing import NamedTuple

from pmwvc_core.law.vectors import Vector, minus, plus, scaled, squared
from pmwvc_core.law.wave.wave import wave_j
from pmwvc_core.params import DeadbandParams

LAST_NUMBER = (1 << 32) - 1  # 1 follows
ROUNDING = 1e-9  # of times, relative


class Packet(NamedTuple):
    """One sample of a wave with the running sums of all samples before it."""

    number: int  # 1, 2, 3 ...
    sent_ns: int  # the sender's clock
    period_s: float  # time that the sample stands for
    wave: Vector  # [sqrt(W)]; without waves a velocity, a force or a position
    integral: Vector  # [sqrt(W) s] running sum of wave * period
    energy_j: float  # running sum: of |wave|^2 period/2, or what was paid for (strict channel)
    position: Vector  # [m] of the sending end
    short: bool  # the sender's playout lacks energy
    waits: bool  # the sender has nothing of the receiver's waves at hand
    anew: bool  # flips whenever the server places the user's avatar anew
    leaves: bool  # the last one of its sender
    extra: Vector  # signals that a controller declares, beside the wave
    echo: int  # number of the newest packet that the sender had of the other end; 0: none
    # Found by the receiver:
    fresh: bool  # begins: the first one, or of a sender that started again
    lost: int  # numbers between it and the one accepted before
    epoch: int  # of the sender: another one where it started again


def no_packet(rest: Vector, extra: Vector) -> Packet:
    """Return what stands for a packet where there is none; ``rest`` are zeros."""
    return Packet(
        0, 0, 0.0, rest, rest, 0.0, rest, False, False, False, False, extra, 0, False, 0, 0
    )


class Sent(NamedTuple):
    """What a port sends at a frame start."""

    wave: Vector
    position: Vector
    energy_j: float  # running sum where the port keeps it; below zero: that of the waves sent
    extra: Vector


class Packing(NamedTuple):
    """The sums of a sender, and the last packet as far as the next one depends on it."""

    number: int
    integral: Vector  # [sqrt(W) s]
    energy_j: float
    held_s: float  # time of the samples held back since the last packet
    sent_integral: Vector  # up to them
    wave: Vector  # of the last packet
    flags: int  # of the last packet
    events: int  # of the limits, as noted last


class PackingParams(NamedTuple):
    """The deadband: ratio of two waves that is not felt (none: below zero), longest time [s]."""

    ratio: float
    longest_s: float


class About(NamedTuple):
    """What a packet says beside its sample."""

    now_ns: int
    short: bool
    waits: bool
    anew: bool
    leaves: bool
    echo: int
    events: int  # of the limits: new ones need a packet


def packing_params(deadband: DeadbandParams) -> PackingParams:
    """Return the parameters of a sender."""
    ratio = deadband.ratio if deadband.is_on else -1.0
    return PackingParams(float(ratio), deadband.longest_s * (1.0 + ROUNDING))


def resting_packing(axes: int) -> Packing:
    """Return a sender that has sent nothing."""
    zero = (0.0,) * axes
    return Packing(0, zero, 0.0, 0.0, zero, zero, 0, 0)


def pay(s: Packing, energy_j: float) -> Packing:
    """Let the next packet bring more energy than its wave needs."""
    return s._replace(energy_j=s.energy_j + energy_j)


def pack(
    s: Packing, sent: Sent, period_s: float, about: About, p: PackingParams
) -> tuple[Packing, Packet, bool]:
    """Add a sample; return its packet, and whether that is sent."""
    integral = plus(s.integral, scaled(sent.wave, period_s))
    energy_j = s.energy_j + wave_j(sent.wave, period_s)
    news = about.events != s.events  # all of this changes with what a packet says
    flags = news * 8 + about.waits * 4 + about.anew * 2 + about.leaves
    number, held_s, wave = s.number % LAST_NUMBER + 1, s.held_s, sent.wave
    same = p.ratio >= 0.0 and s.number > 0 and flags == s.flags
    fits = held_s + 2.0 * period_s <= p.longest_s
    held_back = same and fits and squared(minus(wave, s.wave)) <= p.ratio**2 * squared(s.wave)
    if held_back:
        before = s.sent_integral if held_s > 0.0 else s.integral
        s = s._replace(
            integral=integral, energy_j=energy_j, held_s=held_s + period_s, sent_integral=before,
            events=about.events,
        )  # fmt: skip
    else:
        if held_s > 0.0:
            period_s += held_s
            wave = scaled(minus(integral, s.sent_integral), 1.0 / period_s)
        s = Packing(number, integral, energy_j, 0.0, integral, wave, flags, about.events)
    own = sent.energy_j if sent.energy_j >= 0.0 else energy_j
    packet = Packet(
        number, about.now_ns, period_s, wave, integral, own, sent.position, about.short,
        about.waits, about.anew, about.leaves, sent.extra, about.echo, False, 0, 0,
    )  # fmt: skip
    return s, packet, not held_back
