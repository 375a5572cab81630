# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The parts of an energy budget in words, and what the accounts of controllers mean for it."""

from collections.abc import Iterable, Mapping
from typing import NamedTuple

WORDS: Mapping[str, str] = {
    "device_kinetic": "motion of the device",
    "device_damping": "damping of the device",
    "sample_hold": "sampling and holding at the device",
    "safety": "safety limits",
    "filter": "anti-aliasing filter",
    "rate_drop": "rate drop",
    "filter_and_rate_drop": "anti-aliasing filter and rate drop",
    "filter_and_hold": "anti-aliasing filter and hold",
    "filter_hold_and_rate_drop": "anti-aliasing filter, hold and rate drop",
    "velocity_filter_and_filter": "velocity filter with anti-aliasing filter, hold and rate drop",
    "position_and_surplus": "position feedback with what pays for it",
    "link_up": "link up, and under way on it",
    "link_down": "link down, and under way on it",
    "hold": "hold",
    "link": "link, both ways",
    "late_decoding": "decoding with the force of the step before",
    "integration": "integration of the server",
    "contact_damping": "damping of the contacts",
    "contact_stored": "springs of the contacts",
    "object_kinetic": "motion of the object",
    "object_damping": "damping of the object",
}
# Everything else is the controller's own.
GROUPS: Mapping[str, Iterable[str]] = {
    "devices": ("device_kinetic", "device_damping"),
    "sampling and safety": ("sample_hold", "safety"),
    "filters and holds": ("filter", "rate_drop", "hold", "filter_and_hold"),
    "links": ("link_up", "link_down", "link"),
    "server's computation": ("late_decoding", "integration"),
    "contacts": ("contact_damping", "contact_stored"),
    "object": ("object_kinetic", "object_damping"),
}


class Account(NamedTuple):
    """What a controller's account says: 1 energy taken in and not given on, -1 energy given out,
    0 something else (a level, or what is in another account already).
    """

    words: str
    taken: int


ACCOUNTS: Mapping[str, Account] = {
    "velocity_filter": Account("velocity filter", 1),
    "force_velocity_filter": Account("velocity filter of the force", 0),
    "position_spent": Account("given out by the position feedback", -1),
    "position_surplus": Account("surplus that position feedback may spend", 0),
    "position_discarded": Account("surplus beyond the cap, let go", 0),
    "position_owed": Account("given out by the hold before it was brought", 0),
}


def words_of(part: str) -> str:
    """Return a part or an account in words."""
    if part in ACCOUNTS:
        return ACCOUNTS[part].words
    return WORDS.get(part, part.replace("_", " "))
