# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The packet: one sample of a wave with the running sums of all samples before it, so that a
receiver sees (and the strict channel repairs) loss, duplication and reordering; and its admission:
one end of a user's link seals what it sends and judges what comes in, before anything of it is
believed.

A serialized packet ends with::

    check          = CRC-32 of all bytes but check itself; 0: the sender gives none
    tag            = BLAKE2b-64 of all bytes but check and tag, by the direction's key; 0 without
    session        = BLAKE2b-64(key)                    public: it stands in every packet
    token of user  = BLAKE2b-256(key; name of the user)
    key up, down   = BLAKE2b-256(token; direction)

The checksum finds corrupted bits. The tag finds a packet that was not made with the user's token:
who has one can speak for no other end. A sender faster than any force loop is a flood; each epoch
has a rate of its own, from which packets that come again take nothing. An open session (no token)
has no tags and believes whoever knows the epoch.
"""

import enum
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from hashlib import blake2b
from typing import Protocol

from pmwvc_core.account import Passage
from pmwvc_core.numeric import AXES, Value
from pmwvc_core.quaternions import Orientation

# With what is in flight; without waves of both directions together.
LINK_UP = Passage("link_up", ("u_tx",), ("u_s",))
LINK_DOWN = Passage("link_down", ("v_s",), ("v_rx",))
LINK = Passage("link", ("device",), ("server",))

FLAG_DIRECT = 1  # no wave: a velocity (up), a force or a position (down); see ``content``
FLAG_LEAVING = 2  # the last packet: the sender leaves
FLAG_LIMITED = 4  # the safety limits changed a force since the last packet
FLAG_ANEW = 8  # flips whenever the server places the user's avatar anew
FLAG_WAITING = 16  # the sender has nothing of the receiver's waves at hand (strict channel)
FLAG_SHORT = 32  # the sender's playout lacks energy (strict channel)
FLAG_CHALLENGE = 64  # no wave: it asks a sender that is not followed to echo it
LEVEL_BITS = 8  # above them: level of the impedance behind the wave (strict channel)
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
    MALFORMED = "malformed"  # not a packet, fields of the wrong type, or no orientation
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
    orientation: Orientation = ()  # of the sending end, x y z w; () below six axes
    session: int = 0  # number of the session, 0: an open one
    came_ns: int = 0  # this end's clock at reception where known; no field of the message
    refusal: Receipt | None = None  # found before the receiver, which counts it; no field either


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
    return 124 + 24 * dof + 8 * extra + 40 * (dof == AXES)


KEY_BYTES = 32
LARGEST_RATE_HZ = 2000.0  # of packets: twice a force loop's that sends every tick
BURST = 256  # packets that may come at once, as after an outage that held them back
_EPOCH, _SEQ = slice(20, 28), slice(28, 32)
_CHECK, _SESSION, _TAG = slice(-20, -16), slice(-16, -8), slice(-8, None)
_REMEMBERED = 16  # epochs


@dataclass(frozen=True)
class Token:
    """The key of a session, or the token of one of its users."""

    session: int
    user: str  # "": the key of the whole session
    key: bytes

    @classmethod
    def of_session(cls, key: bytes) -> "Token":
        """Return the key of a session, from random bytes."""
        number = int.from_bytes(blake2b(b"session", key=key, digest_size=8).digest(), "little")
        return cls(number or 1, "", key)

    def of(self, user: str) -> "Token":
        """Return a user's token, from the key of the session."""
        return Token(self.session, user, self.direction(user))

    def direction(self, way: str) -> bytes:
        """Return the key of one direction (``up``, ``down``) of this user."""
        return blake2b(way.encode(), key=self.key, digest_size=KEY_BYTES).digest()


class Admission:
    """One end of a user's link, with the token of the user (None: an open session); ``out`` and
    ``into`` are the directions of what is sent and of what comes in: ``up`` and ``down`` for a
    master.
    """

    def __init__(self, token: Token | None, *, out: str, into: str) -> None:
        self.session = token.session if token else 0
        self._session = self.session.to_bytes(8, "little")
        self._out, self._into = (
            blake2b(key=token.direction(way), digest_size=8) if token else None
            for way in (out, into)
        )
        # epoch -> (packets left, when [ns], greatest number)
        self._rates: dict[bytes, tuple[float, int, int]] = {}

    def sealed(self, data: bytes) -> bytes:
        """Return a serialized packet with session, tag and checksum."""
        body = data[: _CHECK.start]
        tag = bytes(8)
        if self._out is not None:
            mac = self._out.copy()
            mac.update(body + self._session)
            tag = mac.digest()
        end = self._session + tag
        return body + _crc(body, end) + end

    def judge(self, data: bytes, now_ns: int) -> Receipt | None:
        """Return why a serialized packet (a message of the length of one) is refused, or None."""
        body, check, session, tag = data[: _CHECK.start], data[_CHECK], data[_SESSION], data[_TAG]
        if check != bytes(4) and check != _crc(body, session + tag):
            return Receipt.CORRUPTED
        if session != self._session:
            return Receipt.OTHER_SESSION
        if self._into is not None:
            mac = self._into.copy()
            mac.update(body + session)
            if mac.digest() != tag:
                return Receipt.FORGED
        epoch, number = data[_EPOCH], int.from_bytes(data[_SEQ], "little")
        left, at_ns, greatest = self._rates.pop(epoch, (BURST, now_ns, 0))
        left = min(left + (now_ns - at_ns) * 1e-9 * LARGEST_RATE_HZ, BURST)
        if number <= greatest:  # again, or late: for the receiver to judge
            self._rates[epoch] = left, now_ns, greatest
            return None
        self._rates[epoch] = (left - 1.0 if left >= 1.0 else left), now_ns, number
        if len(self._rates) > _REMEMBERED:
            del self._rates[next(iter(self._rates))]
        return None if left >= 1.0 else Receipt.FLOOD


def intact(data: bytes) -> bool:
    """Tell whether a packet's checksum fits, or it has none, or it is none of ours."""
    if (len(data) - size_bytes(0)) % 8:
        return True
    body, check, end = data[: _CHECK.start], data[_CHECK], data[_CHECK.stop :]
    return check == bytes(4) or check == _crc(body, end)


def _crc(body: bytes, end: bytes) -> bytes:
    return zlib.crc32(end, zlib.crc32(body)).to_bytes(4, "little")
