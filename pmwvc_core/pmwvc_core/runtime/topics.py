# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Topics of a loop, and packets as the bytes of a serialized Wave message (CDR, little endian).

A checksum over the bytes shows every corrupted bit, wrong lengths raise nothing. A loop empties
its subscriptions itself (some microseconds; an executor's turn 150, and it passes over them).
"""

import struct
import time
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from typing import Any

from rclpy.callback_groups import CallbackGroup
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from pmwvc_core.ends.inbox import scalar, value, vector
from pmwvc_core.numeric import AXES
from pmwvc_core.quaternions import IDENTITY
from pmwvc_core.runtime.messages import KEPT, NS_PER_S, MessageTypes, record_of
from pmwvc_core.transport.packet import Admission, Receipt, WavePacket, refused, size_bytes

ENCAPSULATION = b"\x00\x01\x00\x00"  # CDR, little endian
CDR = ENCAPSULATION[:2]
MOST_EXTRA = 12
_LENGTH, _DOF_AT = struct.Struct("<I"), 44


@cache
def _layout(dof: int, extra: int) -> tuple[struct.Struct, list[slice]]:
    """Return the layout, the encapsulation and the fields of ``Wave.msg``, and where in it the
    values of each list are, behind their number.
    """
    places, at, turned = [], 8, len(IDENTITY) if dof == AXES else 0
    for count, others in ((dof, 0), (dof, 1), (turned, 0), (dof, 0), (extra, 0)):
        places.append(slice(at + 1, at + 1 + count))
        at += 1 + count + others
    value = f"I4x{dof}d"
    position = f"I4x{turned}d{value}" if turned else f"II{dof}d"  # what is empty leaves no gap
    return struct.Struct(f"<4siIqQIId{value}{value}d{position}I4x{extra}dqqH2xIQQ"), places


def wave_bytes(packet: WavePacket, stamp_ns: int, *, dof: int = 1) -> bytes:
    """Return a packet as a message without checksum and tag; a float stands for each axis."""
    sec, nanosec = divmod(stamp_ns, NS_PER_S)
    turned = (packet.orientation or IDENTITY) if dof == AXES else ()
    return _layout(dof, len(packet.extra))[0].pack(
        ENCAPSULATION, sec, nanosec, packet.sent_ns, packet.epoch, packet.seq, packet.echo_seq,
        packet.period, dof, *vector(packet.wave, dof), dof, *vector(packet.integral, dof),
        scalar(packet.energy), len(turned), *turned, dof, *vector(packet.position, dof),
        len(packet.extra), *packet.extra, packet.echo_sent_ns, packet.echo_hold_ns, packet.flags,
        0, packet.session, 0,
    )  # fmt: skip


def packet_of(data: bytes, *, came_ns: int = 0) -> WavePacket:
    """Return a message as a packet, refused where it is none, with its reception time."""
    (dof,) = _LENGTH.unpack_from(data, _DOF_AT) if len(data) >= size_bytes(0) else (0,)
    extra, rest = divmod(len(data) - size_bytes(dof), 8)
    if rest or not 1 <= dof <= AXES or not 0 <= extra <= MOST_EXTRA or data[:2] != CDR:
        return refused(Receipt.MALFORMED)
    layout, places = _layout(dof, extra)
    found = layout.unpack(data)
    if any(found[place.start - 1] != place.stop - place.start for place in places):
        return refused(Receipt.MALFORMED)
    wave, integral, turned, position, more = (found[place] for place in places)
    _, _, _, sent_ns, epoch, seq, echo_seq, period = found[:8]
    echo_sent_ns, echo_hold_ns, flags, _, session, _ = found[-6:]
    return WavePacket(
        epoch, seq, sent_ns, period, value(wave), value(integral), found[places[1].stop],
        value(position), echo_seq, echo_sent_ns, echo_hold_ns, flags, more, turned, session,
        came_ns,
    )  # fmt: skip


WAVE_QOS = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
RECORDED_QOS = QoSProfile(depth=KEPT, reliability=ReliabilityPolicy.RELIABLE)
LATCHED_QOS = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
# deep enough that a flood does not push out the packets of a sender
TAKEN_QOS = QoSProfile(depth=64, reliability=ReliabilityPolicy.BEST_EFFORT)
MOST_AT_ONCE = 32  # packets taken in one call: a flood takes no more of a loop's time
OF_TOKENS = (Receipt.OTHER_SESSION, Receipt.FORGED)
QUIET_NS = 500_000_000  # an end that has sent nothing for so long answers a wrong token
LONGEST_WAIT_NS = 1_000_000_000  # in the queue; beyond, a wall clock was set meanwhile


def message_class(type_name: str) -> Any:
    """Return the class of messages of a type, ``package/msg/Name``."""
    package, _, name = type_name.partition("/msg/")
    return getattr(import_module(f"{package}.msg"), name)


class _Unserved(CallbackGroup):
    """Entities that no executor ever runs."""

    def can_execute(self, entity: Any) -> bool:
        return False

    beginning_execution = ending_execution = can_execute


class Polled:
    """One subscription, emptied by :meth:`take` or by going through it; its node has to outlive
    the loop that takes.
    """

    def __init__(
        self, node: Node, kind: Any, topic: str, qos: QoSProfile = TAKEN_QOS, *, raw: bool = False
    ) -> None:
        self.kind, self.raw = kind, raw
        self.subscription = node.create_subscription(
            kind, topic, lambda _: None, qos, callback_group=_Unserved()
        )
        self._take = self.subscription.handle.take_message

    def take(self) -> Any:
        """Return the oldest message not yet taken, or None; never waits."""
        taken = self._take(self.kind, self.raw)
        return None if taken is None else taken[0]

    def __iter__(self) -> Iterator[Any]:
        """Go through what has come."""
        return iter(self.take, None)


class WaveTopics:
    """One end of a user's link, with packets of ``dof`` axes; ``admission`` seals and judges. A
    quiet end answers packets of a wrong token with an empty one, which every receiver refuses: so
    the user learns of it.
    """

    def __init__(
        self, node: Node, types: MessageTypes, *, incoming: str, outgoing: str,
        admission: Admission, dof: int, extra: int,
    ) -> None:  # fmt: skip
        self._admission, self._dof, self._sent_ns = admission, dof, 0
        self._whole = size_bytes(dof, extra)
        inlet = Polled(node, types.Wave, incoming, raw=True)
        self._kind, self._inlet = inlet.kind, inlet.subscription.handle
        self._out = node.create_publisher(types.Wave, outgoing, WAVE_QOS)
        record = record_of(self._out.topic_name)
        self._record = node.create_publisher(types.Wave, record, RECORDED_QOS)

    def take(self) -> list[WavePacket]:
        """Return the packets that have arrived since the last call; never wait."""
        packets: list[WavePacket] = []
        take = self._inlet.take_message
        while len(packets) < MOST_AT_ONCE and (taken := take(self._kind, True)) is not None:
            data, info = taken
            now_ns = time.monotonic_ns()
            waited_ns = time.time_ns() - int(info["received_timestamp"])
            came_ns = now_ns - waited_ns if 0 <= waited_ns <= LONGEST_WAIT_NS else now_ns
            verdict = None
            if len(data) == self._whole:
                verdict = self._admission.judge(data, now_ns)
            if verdict in OF_TOKENS and now_ns - self._sent_ns > QUIET_NS:
                self.send(refused(Receipt.MALFORMED))
            packets.append(refused(verdict) if verdict else packet_of(data, came_ns=came_ns))
        return packets

    def send(self, packet: WavePacket) -> None:
        """Publish a packet."""
        self._sent_ns = time.monotonic_ns()
        data = self._admission.sealed(wave_bytes(packet, time.time_ns(), dof=self._dof))
        self._out.publish(data)
        self._record.publish(data)
