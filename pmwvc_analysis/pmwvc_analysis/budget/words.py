# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The words of an energy budget: its parts by name, and the accounts that blocks keep."""

from collections.abc import Iterable, Mapping

from pmwvc_core.controllers import entries
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
    "bank": "splitting and joining of the filter bank",
    "link_up": "link up with packets in flight",
    "link_down": "link down with packets in flight",
    "hold": "hold",
    "link": "link in both directions",
    "integration": "integration of the server",
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


def accounted(accounts: Mapping[str, Array]) -> dict[str, Array]:
    """Return the accounts that are parts of a budget, as energy taken in."""
    signs = {name: entry.sign for name, entry in entries().items()}
    return {name: signs[name] * sums for name, sums in accounts.items() if signs.get(name)}


def words_of(part: str) -> str:
    """Return a part in words, or several that are judged together."""
    if part in WORDS:
        return WORDS[part]
    if "_and_" in part:
        return ", ".join(words_of(each) for each in part.split("_and_"))
    entry = entries().get(part)
    return entry.part or entry.words if entry else part.replace("_", " ")


def account_words(account: str) -> str:
    """Return a controller's account in words."""
    entry = entries().get(account)
    return entry.words if entry else account.replace("_", " ")
