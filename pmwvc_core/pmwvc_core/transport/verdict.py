# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The verdicts on a packet that has come in."""

import enum


class Verdict(enum.Enum):
    """Verdict on a packet. Only the first two change the wave that the receiver gives out."""

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
