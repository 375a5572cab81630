# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The duplication of packets."""

from pmwvc_core.network.effects.record import Effect, LinkEffect, no_time
from pmwvc_core.network.in_flight import Fate


class Duplication(Effect):
    """Copy packets independently of one another."""

    def copies(self, fate: Fate) -> int:
        """Return 1 where a packet is copied, else 0."""
        return int(self.uniform(fate) < self.params.duplicate)


RECORD = LinkEffect(
    name="duplication",
    words="Packets arrive twice, each with the same probability.",
    linear="delay",
    make=Duplication,
    parameters=("duplicate",),
    active=lambda params: params.duplicate > 0.0,
    slot=1,
    amount=lambda params: f"duplication of {params.duplicate:.3g} of the packets",
    spread_s=no_time,
    off=0.0,
)
