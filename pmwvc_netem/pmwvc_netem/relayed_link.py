# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One relayed topic: messages in, through a link, out; and the record of it.

A message is a string of bytes and stays one: nothing is decoded. Only epoch and sequence number
are looked at, where they stand in the CDR encoding of a Wave::

    0  encapsulation (byte 1: 1 for little endian)    20  epoch  (uint64)
    4  stamp         (int32, uint32)                  28  seq    (uint32)
    12 sent_ns       (int64)

No ROS and no clock here: where bytes come from, go to, and what time it is are arguments.
"""

import struct
from collections.abc import Callable

from pmwvc_core.network.in_flight import TRAVELLING, Cause, Fate, FateKind, FateLog
from pmwvc_core.network.link import Link

ENCAPSULATION = 4  # bytes that even an empty message has
_EPOCH = 20
_WAVE_HEAD = 32
_EPOCH_AND_SEQ = {0: struct.Struct(">QI"), 1: struct.Struct("<QI")}


def peek_wave(message: bytes) -> tuple[int, int] | None:
    """Return epoch and sequence number of a serialized Wave; None when it is none."""
    if len(message) < _WAVE_HEAD or message[1] not in _EPOCH_AND_SEQ:
        return None
    epoch, seq = _EPOCH_AND_SEQ[message[1]].unpack_from(message, _EPOCH)
    return epoch, seq


def flipped(message: bytes, fraction: float) -> bytes:
    """Return a message with a bit flipped at a fraction in [0, 1) of what is not encapsulation."""
    bits = bytearray(message)
    number = int(fraction * 8 * (len(message) - ENCAPSULATION))
    if number < 8 * (len(message) - ENCAPSULATION):
        bits[ENCAPSULATION + number // 8] ^= 1 << number % 8
    return bytes(bits)


class RelayedLink:
    """One topic's way through its link, which decides on delay and loss.

    ``take`` returns the next message that has come in, or None; ``give`` sends one on; ``clock``
    is the monotonic clock [ns].
    """

    def __init__(
        self, name: str, link: Link, *, take: Callable[[], bytes | None],
        give: Callable[[bytes], None], clock: Callable[[], int],
    ) -> None:  # fmt: skip
        self.name, self.link = name, link
        self.fates = FateLog()
        self.invalid = self._count = 0
        self.late_ns = 0  # latest release since somebody looked
        self._take, self._give, self._clock = take, give, clock

    def take_in(self) -> None:
        """Put everything that has come in onto the link."""
        while (message := self._take()) is not None:
            now_ns, size = self._clock(), len(message)
            self._count += 1
            if (known := peek_wave(message)) is None:
                self.invalid += 1
                self.fates.add(Fate(self._count, now_ns, kind=FateKind.INVALID, size=size))
                continue
            for fate in self.link.send((message, *known), now_ns, size_bytes=size):
                if fate.kind not in TRAVELLING:
                    self.fates.add(fate, epoch=known[0], seq=known[1])

    def let_out(self) -> None:
        """Send on everything that is due."""
        now_ns = self._clock()
        due_ns = self.link.next_due_ns
        if due_ns is None or due_ns > now_ns:
            return
        for (message, epoch, seq), fate in self.link.arrivals(now_ns):
            if fate.cause is Cause.CORRUPTION:
                message = flipped(message, fate.flip)
            out_ns = self._clock()
            self._give(message)
            self.fates.add(fate, time_out_ns=out_ns, epoch=epoch, seq=seq)
            self.late_ns = max(self.late_ns, out_ns - fate.time_due_ns)

    def end(self) -> None:
        """Close the record: what is still under way never comes out."""
        for (_, epoch, seq), fate in self.link.arrivals(1 << 62):
            self.fates.add(fate, epoch=epoch, seq=seq)
