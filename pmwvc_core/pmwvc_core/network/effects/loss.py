# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The loss of single packets."""

from pmwvc_core.network.effects.record import Effect, LinkEffect, no_time
from pmwvc_core.network.in_flight import Fate


class Loss(Effect):
    """Lose packets independently of one another."""

    def loses(self, fate: Fate) -> bool:
        """Tell whether a packet is lost."""
        return self.uniform(fate) < self.params.loss


RECORD = LinkEffect(
    name="loss",
    words="Packets are lost, each with the same probability.",
    linear="delay",
    make=Loss,
    parameters=("loss",),
    active=lambda params: params.loss > 0.0,
    slot=0,
    amount=lambda params: f"loss of {params.loss:.3g} of the packets",
    label=lambda params: f"loss {float(params.loss * 100.0):.4g} %",
    spread_s=no_time,
    off=0.0,
)
