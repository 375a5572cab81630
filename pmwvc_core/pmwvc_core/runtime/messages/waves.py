# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Packets as Wave messages, as recordings hold them; loops send bytes (:mod:`.wire`)."""

from typing import Any

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
        check=0,
        session=packet.session,
        tag=0,
    )
