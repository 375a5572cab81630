# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Session tokens: who may send packets as which user.

The server holds the key of a session; each user is given a token made from it when joining, and
can neither speak for another user nor for the server with another one. Each direction has its own
key::

    session        = BLAKE2b-64(key)                    public: it stands in every packet
    token of user  = BLAKE2b-256(key; name of the user)
    key up, down   = BLAKE2b-256(token; direction)
"""

from dataclasses import dataclass
from hashlib import blake2b

KEY_BYTES = 32


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
        return Token(self.session, user, _derived(self.key, user.encode()))

    def direction(self, way: str) -> bytes:
        """Return the key of one direction (``up``, ``down``) of this user."""
        return _derived(self.key, way.encode())


def _derived(key: bytes, name: bytes) -> bytes:
    return blake2b(name, key=key, digest_size=KEY_BYTES).digest()
