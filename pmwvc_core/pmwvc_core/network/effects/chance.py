# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Packets copied, corrupted or sent at once, each by chance."""

from pmwvc_core.network.effects.record import Effect, linux_effect
from pmwvc_core.network.in_flight import Fate


class Duplication(Effect):
    """Copy packets with one probability."""

    def copies(self, fate: Fate) -> int:
        """Return 1 where a packet is copied, else 0."""
        rho = self.params.duplicate_correlation
        return int(self.chain.draw(self.uniform(fate), rho) < self.params.duplicate)


DUPLICATION = linux_effect(
    name="duplication",
    words="Packets arrive twice, each with the same probability.",
    make=Duplication,
    parameters=("duplicate", "duplicate_correlation"),
    active=lambda params: params.duplicate > 0.0,
    slot=1,
    amount=lambda params: f"duplication of {params.duplicate:.3g} of the packets",
)


class Corruption(Effect):
    """Corrupt packets and copies with one probability: one bit is flipped."""

    def corrupts(self, fate: Fate) -> float | None:
        """Return where in the packet, in [0, 1); None where it stays as it is."""
        rho = self.params.corrupt_correlation
        u = self.chain.draw(self.uniform(fate), rho, goes_on=not fate.copy)
        return self.uniform(fate, 1) if u < self.params.corrupt else None


CORRUPTION = linux_effect(
    name="corruption",
    words="One bit of a packet is flipped, with the same probability in each.",
    make=Corruption,
    parameters=("corrupt", "corrupt_correlation"),
    active=lambda params: params.corrupt > 0.0,
    amount=lambda params: f"corruption of {params.corrupt:.3g} of the packets",
    label=lambda params: f"corrupt {float(params.corrupt * 100.0):.4g} %",
)


class Reordering(Effect):
    """Send at once, with one probability, one packet after every ``reorder_gap - 1`` others."""

    _since = 0  # packets since the last one sent at once

    def at_once(self, fate: Fate) -> bool:
        """Tell whether a packet or copy goes without delay."""
        rho = self.params.reorder_correlation
        u = self.chain.draw(self.uniform(fate), rho, goes_on=not fate.copy)
        if self._since < self.params.reorder_gap - 1 or u >= self.params.reorder:
            self._since += 1
            return False
        self._since = 0
        return True


REORDERING = linux_effect(
    name="reordering",
    words="Some packets are sent at once and overtake others.",
    make=Reordering,
    parameters=("reorder", "reorder_gap", "reorder_correlation"),
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
