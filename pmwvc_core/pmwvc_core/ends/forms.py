# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Signals and packets in the two forms they have: outside and in the laws.

Outside a signal of one axis is a float, one of several an array ``(dof,)``; in the laws both are
tuples.
"""

import numpy as np

from pmwvc_core.law.channel.packet import Packet
from pmwvc_core.law.vectors import Vector
from pmwvc_core.numeric import Value
from pmwvc_core.transport.packet import FLAG_ANEW, FLAG_LEAVING, FLAG_WAITING, WavePacket


def vector(value: Value, dof: int) -> Vector:
    """Return a signal as the laws have it; a number stands for all axes."""
    if isinstance(value, np.ndarray) and value.ndim:
        return tuple(value.tolist())
    return (float(value),) * dof


def scalar(value: Value) -> float:
    """Return a quantity of the whole (an energy), which a plug-in may give as an array of one."""
    return vector(value, 1)[0]


def value(signal: Vector) -> Value:
    """Return a signal of the laws as others have it."""
    return signal[0] if len(signal) == 1 else np.array(signal)


def known(packet: WavePacket, dof: int, *, fresh: bool, lost: int) -> Packet:
    """Return an accepted packet as the laws have it."""
    flags, energy_j = packet.flags, scalar(packet.energy)
    wave, integral, position = (
        vector(each, dof) for each in (packet.wave, packet.integral, packet.position)
    )
    return Packet(
        packet.seq, packet.sent_ns, packet.period, wave, integral, energy_j, position,
        bool(packet.short), bool(flags & FLAG_WAITING), bool(flags & FLAG_ANEW),
        bool(flags & FLAG_LEAVING), packet.extra, packet.echo_seq, fresh, lost, packet.epoch,
    )  # fmt: skip


def message(packet: Packet, epoch: int, flags: int, echo: tuple[int, int, int]) -> WavePacket:
    """Return a packet of the laws for the link, with its sender's life, flags and echo."""
    flags |= packet.waits * FLAG_WAITING | packet.anew * FLAG_ANEW | packet.leaves * FLAG_LEAVING
    return WavePacket(
        epoch, packet.number, packet.sent_ns, packet.period_s, value(packet.wave),
        value(packet.integral), packet.energy_j, value(packet.position), *echo, flags,
        packet.extra, short=packet.short,
    )  # fmt: skip
