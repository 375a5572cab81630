# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Packets as the bytes of a serialized Wave message (CDR, little endian), and back.

A loop sends and takes bytes: a checksum over them shows every corrupted bit, a message whose
lengths are wrong raises nothing, and both cost less than message objects. Offsets follow from the
field order in ``Wave.msg``.
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
_SPARE = 24  # bytes that the middleware adds to a message with empty sequences
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
    """Return a message as a packet; one that cannot be one as a packet that is refused.
    ``came_ns`` is this end's clock at its reception.
    """
    (dof,) = _LENGTH.unpack_from(data, _DOF_AT) if len(data) >= _FIXED else (0,)
    extra, rest = divmod(len(data) - _FIXED - dof * _PER_AXIS, 8)
    if rest or not 1 <= dof <= MOST_AXES or not 0 <= extra <= MOST_EXTRA or data[:2] != CDR:
        return refused(_other_lengths(data))
    found = _layout(dof, extra).unpack(data)
    integral, energy, position = 10 + dof, 10 + 2 * dof, 12 + 2 * dof
    beside = position + dof + 1
    same = found[8] == found[integral - 1] == found[position - 1] == dof
    if not same or found[beside - 1] != extra:
        return refused(_other_lengths(data))
    return WavePacket(
        epoch=found[4],
        seq=found[5],
        sent_ns=found[3],
        period=found[7],
        wave=_value(found[9 : 9 + dof]),
        integral=_value(found[integral : integral + dof]),
        energy=found[energy],
        position=_value(found[position : position + dof]),
        extra=found[beside : beside + extra],
        echo_seq=found[6],
        echo_sent_ns=found[-6],
        echo_hold_ns=found[-5],
        flags=found[-4] & ~FLAG_SHORT,
        session=found[-2],
        short=bool(found[-4] & FLAG_SHORT),
        came_ns=came_ns,
    )


def _other_lengths(data: bytes) -> Verdict:
    """Return the verdict on a message that is no packet: a Wave with other lengths, or none."""
    body = data[len(ENCAPSULATION) :]
    at = 40  # behind period
    try:
        for behind in (0, 8, 0, 0):  # behind wave, integral (energy), position, extra
            (length,) = struct.unpack_from("<I", body, at)
            at += 4 + (-(at + 4) % 8 + 8 * length if length else 0)
            at += -at % 8 + behind if behind else 0
    except struct.error:
        return Verdict.MALFORMED
    at += -at % 8 + 40  # two times, flags, check, session, tag
    whole = at <= len(body) <= at + _SPARE
    return Verdict.WRONG_LENGTH if whole else Verdict.MALFORMED


def _value(values: tuple[float, ...]) -> Value:
    return values[0] if len(values) == 1 else np.array(values)
