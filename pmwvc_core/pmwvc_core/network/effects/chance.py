# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Packets copied, corrupted or sent at once, each by chance."""

from pmwvc_core.network.effects.record import Effect, linux_effect, made_of
from pmwvc_core.network.in_flight import Fate


def copies(effect: Effect, fate: Fate) -> int:
    """Copy packets with one probability."""
    p = effect.params
    return int(effect.correlated(fate, p.duplicate_correlation) < p.duplicate)


def corrupts(effect: Effect, fate: Fate) -> float | None:
    """Corrupt packets and copies with one probability: one bit is flipped."""
    p = effect.params
    flips = effect.correlated(fate, p.corrupt_correlation) < p.corrupt
    return effect.uniform(fate, 1) if flips else None


class Reordering(Effect):
    """Send at once, with one probability, one packet after every ``reorder_gap - 1`` others."""

    _since = 0  # packets since the last one sent at once

    def at_once(self, fate: Fate) -> bool:
        """Tell whether a packet or copy goes without delay."""
        p = self.params
        u = self.correlated(fate, p.reorder_correlation)
        at_once = self._since >= p.reorder_gap - 1 and u < p.reorder
        self._since = 0 if at_once else self._since + 1
        return at_once


DUPLICATION = linux_effect(
    name="duplication",
    words="Packets arrive twice, each with the same probability.",
    make=made_of(copies=copies),
    active=lambda params: params.duplicate > 0.0,
    slot=1,
    amount=lambda params: f"duplication of {params.duplicate:.3g} of the packets",
)
CORRUPTION = linux_effect(
    name="corruption",
    words="One bit of a packet is flipped, with the same probability in each.",
    make=made_of(corrupts=corrupts),
    active=lambda params: params.corrupt > 0.0,
    amount=lambda params: f"corruption of {params.corrupt:.3g} of the packets",
    label=lambda params: f"corrupt {float(params.corrupt * 100.0):.4g} %",
)
REORDERING = linux_effect(
    name="reordering",
    words="Some packets are sent at once and overtake others.",
    make=Reordering,
    active=lambda params: params.reorder > 0.0,
    spreads=True,
    amount=lambda params: f"reordering of {params.reorder:.3g} of the packets",
    label=lambda params: f"reorder {float(params.reorder * 100.0):.4g} %",
    conflict=lambda params: (
        f"reorder = {params.reorder:g}: nothing is reordered unless keep_order is false"
        if params.keep_order
        else ""
    ),
)
