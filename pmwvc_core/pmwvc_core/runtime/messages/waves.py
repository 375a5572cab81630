# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Packets as Wave messages, and back."""

from typing import Any

import numpy as np

from pmwvc_core.numeric import Value
from pmwvc_core.runtime.messages.fields import Numbers, Wave
from pmwvc_core.runtime.messages.types import MessageTypes, axes, scalar, time_message
from pmwvc_core.transport.packet import WavePacket


def wave(types: MessageTypes, packet: WavePacket, stamp_ns: int, *, dof: int = 1) -> Any:
    """Return a packet as a Wave message; a float stands for that value on each of ``dof`` axes."""
    return types.Wave(
        stamp=time_message(types, stamp_ns),
        sent_ns=packet.sent_ns,
        epoch=packet.epoch,
        seq=packet.seq,
        period=packet.period,
        wave=types.sequence(axes(packet.wave, dof), "d"),
        integral=types.sequence(axes(packet.integral, dof), "d"),
        energy=scalar(packet.energy),
        position=types.sequence(axes(packet.position, dof), "d"),
        echo_seq=packet.echo_seq,
        echo_sent_ns=packet.echo_sent_ns,
        echo_hold_ns=packet.echo_hold_ns,
        flags=packet.flags,
    )


def read_wave(msg: Wave, dof: int) -> WavePacket:
    """Return a Wave message as a packet, whatever it holds.

    A sequence of another length than ``dof`` becomes an array of its own length, for the receiver
    to refuse.
    """
    return WavePacket(
        epoch=msg.epoch,
        seq=msg.seq,
        sent_ns=msg.sent_ns,
        period=msg.period,
        wave=_value(msg.wave, dof),
        integral=_value(msg.integral, dof),
        energy=msg.energy,
        position=_value(msg.position, dof),
        echo_seq=msg.echo_seq,
        echo_sent_ns=msg.echo_sent_ns,
        echo_hold_ns=msg.echo_hold_ns,
        flags=msg.flags,
    )


def _value(sequence: Numbers, dof: int) -> Value:
    if dof == 1 and len(sequence) == 1:
        return float(sequence[0])
    return np.array(sequence, dtype=float)
