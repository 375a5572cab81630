# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The packet: one sample of a wave with the running sums of all samples before it, so that a
receiver sees (and the strict channel repairs) loss, duplication and reordering.
"""

import enum
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from pmwvc_core.account import Passage
from pmwvc_core.numeric import Value

# With what is in flight; without waves of both directions together.
LINK_UP = Passage("link_up", ("u_tx",), ("u_s",))
LINK_DOWN = Passage("link_down", ("v_s",), ("v_rx",))
LINK = Passage("link", ("device",), ("server",))

FLAG_DIRECT = 1  # no wave: a velocity (up), a force or a position (down); see ``content``
FLAG_LEAVING = 2  # the last packet: the sender leaves
FLAG_LIMITED = 4  # the safety limits changed a force since the last packet
FLAG_ANEW = 8  # flips whenever the server places the user's avatar anew
FLAG_WAITING = 16  # the sender has nothing of the receiver's waves at hand (strict channel)
FLAG_SHORT = 32  # of a message: ``short``
FLAG_CHALLENGE = 64  # no wave: it asks a sender that is not followed to echo it
LAST_NUMBER = (1 << 32) - 1  # 1 follows


class Receipt(enum.Enum):
    """Verdict on a packet that has come in. Only the first two change the receiver's wave."""

    ACCEPTED = "accepted"
    NEW_EPOCH = "new epoch"  # accepted as a beginning: first packet, restarted sender
    DUPLICATE = "duplicate"
    REORDERED = "reordered"  # older than the newest
    STALE = "stale"  # of a sender that has left, or far from its numbers
    STRANGER = "of another sender"  # which is not followed
    CORRUPTED = "corrupted"  # its bytes do not fit its checksum
    OTHER_SESSION = "of another session"
    FORGED = "forged"  # without the token of the user it claims to be from
    FLOOD = "beyond the rate of a sender"
    MALFORMED = "malformed"  # not a packet, or fields of the wrong type
    NOT_FINITE = "not finite"
    WRONG_LENGTH = "wrong length"
    WRONG_PERIOD = "wrong period"
    TOO_LARGE = "too large"

    __hash__ = object.__hash__  # that of Enum takes the hash of the name, in Python


@dataclass(slots=True)
class WavePacket:
    """One packet; values are floats, or arrays ``(dof,)`` of several axes."""

    epoch: int  # random at each start of the sender
    seq: int  # 1, 2, 3...
    sent_ns: int  # the sender's monotonic clock
    period: float  # [s] one sample stands for
    wave: Value  # [sqrt(W)]
    integral: Value  # [sqrt(W) s] running sum of wave * period
    energy: Value  # [J] running sum of |wave|^2 * period / 2
    position: Value  # [m] of the sending end, for information
    echo_seq: int = 0  # newest packet of the peer: its number (0: none yet),
    echo_sent_ns: int = 0  # the peer's clock when it was sent,
    echo_hold_ns: int = 0  # and how long ago it came in here
    flags: int = 0
    extra: tuple[float, ...] = ()  # signals beside the wave, as the controller declares them
    session: int = 0  # number of the session, 0: an open one
    short: bool = False  # the sender's playout lacks energy; in a message a flag
    came_ns: int = 0  # this end's clock at reception where known; no field of the message
    refusal: Receipt | None = None  # found before the receiver, which counts it; no field either

    @property
    def message_flags(self) -> int:
        """Return the flags of the message that carries it."""
        return self.flags | (FLAG_SHORT if self.short else 0)


def ahead(before: WavePacket, packet: WavePacket) -> int:
    """Return by how much a packet's number is above another's; after the last comes 1."""
    half = LAST_NUMBER // 2
    return (packet.seq - before.seq + half) % LAST_NUMBER - half


def refused(verdict: Receipt) -> WavePacket:
    """Return a packet whose fields cannot be trusted, for a receiver to count as this."""
    return WavePacket(0, 1, 0, 0.0, 0.0, 0.0, 0.0, 0.0, refusal=verdict)


class PacketLink(Protocol):
    """One end of a user's link, as a live loop uses it."""

    def take(self) -> Sequence[WavePacket]:
        """Return the packets that have arrived since the last call; never wait."""

    def send(self, packet: WavePacket) -> None:
        """Send a packet to the other end."""


def size_bytes(dof: int, extra: int = 0) -> int:
    """Return the size of a serialized Wave message (CDR), with ``extra`` signals."""
    return 124 + 24 * dof + 8 * extra
