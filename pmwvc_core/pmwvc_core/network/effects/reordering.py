# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The reordering of packets: some are sent at once and overtake those that wait."""

from pmwvc_core.network.effects.record import Effect, linux_effect
from pmwvc_core.network.in_flight import Fate


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


RECORD = linux_effect(
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
