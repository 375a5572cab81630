# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Packets as the bytes of a serialized Wave message (CDR, little endian), and back: a checksum
over them shows every corrupted bit, wrong lengths raise nothing. Offsets are those of
``Wave.msg``.
"""

import struct
from functools import cache

import numpy as np

from pmwvc_core.numeric import Value
from pmwvc_core.runtime.messages import NS_PER_S, axes, scalar
from pmwvc_core.transport.packet import FLAG_SHORT, Verdict, WavePacket, refused, size_bytes

ENCAPSULATION = b"\x00\x01\x00\x00"  # CDR, little endian
CDR = ENCAPSULATION[:2]
MOST_AXES, MOST_EXTRA = 6, 12
_LENGTH, _DOF_AT = struct.Struct("<I"), 44
_FIXED = size_bytes(0)
_PER_AXIS = size_bytes(1) - _FIXED


@cache
def _layout(dof: int, extra: int) -> struct.Struct:
    """Return the layout: the encapsulation and the fields of ``Wave.msg``."""
    value = f"I4x{dof}d"
    return struct.Struct(f"<4siIqQIId{value}{value}d{value}I4x{extra}dqqH2xIQQ")


def wave_bytes(packet: WavePacket, stamp_ns: int, *, dof: int = 1) -> bytes:
    """Return a packet as a message without checksum and tag; a float stands for each axis."""
    sec, nanosec = divmod(stamp_ns, NS_PER_S)
    return _layout(dof, len(packet.extra)).pack(
        ENCAPSULATION, sec, nanosec, packet.sent_ns, packet.epoch, packet.seq, packet.echo_seq,
        packet.period, dof, *axes(packet.wave, dof), dof, *axes(packet.integral, dof),
        scalar(packet.energy), dof, *axes(packet.position, dof), len(packet.extra), *packet.extra,
        packet.echo_sent_ns, packet.echo_hold_ns, packet.message_flags, 0, packet.session, 0,
    )  # fmt: skip


def packet_of(data: bytes, *, came_ns: int = 0) -> WavePacket:
    """Return a message as a packet, refused where it is none, with its reception time."""
    (dof,) = _LENGTH.unpack_from(data, _DOF_AT) if len(data) >= _FIXED else (0,)
    extra, rest = divmod(len(data) - _FIXED - dof * _PER_AXIS, 8)
    if rest or not 1 <= dof <= MOST_AXES or not 0 <= extra <= MOST_EXTRA or data[:2] != CDR:
        return refused(Verdict.MALFORMED)
    _, _, _, sent_ns, epoch, seq, echo_seq, period, *body = _layout(dof, extra).unpack(data)
    second, third, last = dof + 1, 2 * dof + 3, 3 * dof + 4  # where lengths stand
    if [body[0], body[second], body[third], body[last]] != [dof, dof, dof, extra]:
        return refused(Verdict.MALFORMED)
    wave, integral, position = (_value(body[at + 1 : at + 1 + dof]) for at in (0, second, third))
    echo_sent_ns, echo_hold_ns, flags, _, session, _ = body[-6:]
    return WavePacket(
        epoch, seq, sent_ns, period, wave, integral, body[third - 1], position,
        echo_seq, echo_sent_ns, echo_hold_ns, flags & ~FLAG_SHORT,
        tuple(body[last + 1 : last + 1 + extra]), session, bool(flags & FLAG_SHORT), came_ns,
    )  # fmt: skip


def _value(values: list[float]) -> Value:
    return values[0] if len(values) == 1 else np.array(values)
