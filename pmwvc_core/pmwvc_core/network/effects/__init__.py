# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Link effects by name: what a link does to its packets."""

from pmwvc_core.network.effects.library import (
    EFFECTS,
    active,
    amounts,
    check,
    conflicts,
    is_random,
    longest_s,
    mean_s,
    numbers_of,
    unbounded,
)
from pmwvc_core.network.effects.record import Effect, LinkEffect, Uniform

__all__ = [
    "EFFECTS",
    "Effect",
    "LinkEffect",
    "Uniform",
    "active",
    "amounts",
    "check",
    "conflicts",
    "is_random",
    "longest_s",
    "mean_s",
    "numbers_of",
    "unbounded",
]
