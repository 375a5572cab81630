# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Link effects by name, one file each: what a link does to its packets."""

from pmwvc_core.network.effects.library import (
    EFFECTS,
    active,
    check,
    conflicts,
    is_random,
    numbers_of,
    spread_s,
)
from pmwvc_core.network.effects.record import Effect, LinkEffect, Uniform

__all__ = [
    "EFFECTS",
    "Effect",
    "LinkEffect",
    "Uniform",
    "active",
    "check",
    "conflicts",
    "is_random",
    "numbers_of",
    "spread_s",
]
