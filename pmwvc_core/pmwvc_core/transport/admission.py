# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The admission of packets: one end of a user's link seals what it sends and judges what comes in,
before anything of it is believed.

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

import zlib
from dataclasses import dataclass
from hashlib import blake2b

from pmwvc_core.transport.packet import Receipt, size_bytes

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
