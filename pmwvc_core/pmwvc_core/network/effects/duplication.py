# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The duplication of packets."""

from pmwvc_core.network.effects.record import Effect, linux_effect
from pmwvc_core.network.in_flight import Fate


class Duplication(Effect):
    """Copy packets with one probability."""

    def copies(self, fate: Fate) -> int:
        """Return 1 where a packet is copied, else 0."""
        rho = self.params.duplicate_correlation
        return int(self.chain.draw(self.uniform(fate), rho) < self.params.duplicate)


RECORD = linux_effect(
    name="duplication",
    words="Packets arrive twice, each with the same probability.",
    make=Duplication,
    parameters=("duplicate", "duplicate_correlation"),
    active=lambda params: params.duplicate > 0.0,
    slot=1,
    amount=lambda params: f"duplication of {params.duplicate:.3g} of the packets",
)
