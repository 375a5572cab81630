# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What one end says to the other, as the laws see it; not its message."""

from typing import NamedTuple

from pmwvc_core.law.vectors import Vector


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
