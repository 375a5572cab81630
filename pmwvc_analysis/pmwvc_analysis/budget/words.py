# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The words of an energy budget: its parts and accounts by name."""

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from pmwvc_core.numeric import Array

WORDS: Mapping[str, str] = {
    "device_kinetic": "motion of the device",
    "device_damping": "damping of the device",
    "sample_hold": "sampling and holding at the device",
    "safety": "safety limits",
    "filter": "anti-aliasing filter",
    "rate_drop": "rate drop",
    "filter_and_rate_drop": "anti-aliasing filter and rate drop",
    "filter_and_hold": "anti-aliasing filter and hold",
    "velocity_filter": "velocity filter",
    "force_velocity_filter": "velocity filter of the force",
    "bank": "splitting and joining of the filter bank",
    "link_up": "link up with packets in flight",
    "link_down": "link down with packets in flight",
    "hold": "hold",
    "node": "account of the device's node",
    "link": "link in both directions",
    "tdpa_dissipated": "passivity controller",
    "late_decoding": "decoding with the force of the previous step",
    "integration": "integration of the server",
    "withheld": "compensation of the server port",
    "contained": "damper in place of a failed environment",
    "environment_stored": "stored by the environment",
    "environment_heat": "dissipated in the environment",
    "environment_stored_and_environment_heat": "environment",
    "contact_damping": "damping of the contacts",
    "contact_stored": "springs of the contacts",
    "object_kinetic": "motion of the object",
    "object_damping": "damping of the object",
}
# Everything else is the controller's own.
GROUPS: Mapping[str, Iterable[str]] = {
    "devices": ("device_kinetic", "device_damping"),
    "sampling and safety": ("sample_hold", "safety"),
    "filters and holds": (
        "filter",
        "rate_drop",
        "hold",
        "filter_and_hold",
        "node",
        "node_and_link_down",
    ),
    "links": ("link_up", "link_down", "link"),
    "server's computation": ("late_decoding", "integration", "withheld", "contained"),
    "contacts": ("contact_damping", "contact_stored", "environment_stored", "environment_heat"),
    "object": ("object_kinetic", "object_damping"),
}


class Account(NamedTuple):
    """A controller's account and its sign in the budget.

    ``taken`` is 1 for energy taken in and not given on, -1 for energy given out, 0 for anything
    else (a level, or energy that another account contains already).
    """

    words: str
    taken: int


ACCOUNTS: Mapping[str, Account] = {
    "velocity_filter": Account("kept by the velocity filter", 1),
    "force_velocity_filter": Account("kept by the velocity filter of the force", 0),
    "local_stored": Account("spring of the local model", 1),
    "local_dissipated": Account("damping of the local model", 1),
    "bank_low_in": Account("to the server, behind the bank", 0),
    "bank_low_out": Account("from the server, before the bank", 0),
    "bank_high_in": Account("to the local model", 0),
    "bank_high_out": Account("from the local model", 0),
    "position_spent": Account("released by the position feedback", -1),
    "position_surplus": Account("energy tank of the position feedback", 0),
    "position_discarded": Account("energy above the cap of the tank, discarded", 0),
    "position_owed": Account("returned by the hold before its packet arrived", 0),
    "node": Account("not paid to packets yet, at the device's node", 0),
    "playout_given": Account("given out by the playout", 0),
    "playout_free": Account("in the playout, beyond what its wave needs", 0),
    "playout_discarded": Account("in the playout beyond its cap, discarded", 0),
    "environment": Account("taken by the environment", 0),
    "late_decoding": Account("decoding with the force of the previous step", 0),
    "withheld": Account("withheld by the compensation", 0),
    "contained": Account("dissipated in place of a failed environment", 0),
    "tank": Account("energy tank of the server port", 0),
    "granted": Account("taken from the allowance", 0),
    "capped": Account("received above the cap, not stored", 0),
    "tdpa_dissipated": Account("dissipated by the passivity controller", 1),
    "tdpa_allowance": Account("energy that may still be released", 0),
    "pspm_tank": Account("energy tank of the set points", 0),
    "pspm_spring": Account("springs to the set points", 0),
    "debt": Account("deficit, recovered from later waves", 0),
}


def accounted(accounts: Mapping[str, Array]) -> dict[str, Array]:
    """Return the accounts that are parts of a budget, as energy taken in."""
    known = {name: ACCOUNTS[name].taken for name in accounts if name in ACCOUNTS}
    return {name: sign * accounts[name] for name, sign in known.items() if sign}


def words_of(part: str) -> str:
    """Return a part in words, or several that are judged together."""
    if part in WORDS:
        return WORDS[part]
    if "_and_" in part:
        return ", ".join(words_of(each) for each in part.split("_and_"))
    return ACCOUNTS[part].words if part in ACCOUNTS else part.replace("_", " ")


def account_words(account: str) -> str:
    """Return a controller's account in words."""
    return ACCOUNTS[account].words if account in ACCOUNTS else account.replace("_", " ")
