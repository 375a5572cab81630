# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The corruption of packets: one bit is flipped; which one is the link's owner's to know."""

from pmwvc_core.network.effects.record import Effect, linux_effect
from pmwvc_core.network.in_flight import Fate


class Corruption(Effect):
    """Corrupt packets and copies with one probability."""

    def corrupts(self, fate: Fate) -> float | None:
        """Return where in the packet, in [0, 1); None where it stays as it is."""
        rho = self.params.corrupt_correlation
        u = self.chain.draw(self.uniform(fate), rho, goes_on=not fate.copy)
        return self.uniform(fate, 1) if u < self.params.corrupt else None


RECORD = linux_effect(
    name="corruption",
    words="One bit of a packet is flipped, with the same probability in each.",
    make=Corruption,
    parameters=("corrupt", "corrupt_correlation"),
    active=lambda params: params.corrupt > 0.0,
    amount=lambda params: f"corruption of {params.corrupt:.3g} of the packets",
    label=lambda params: f"corrupt {float(params.corrupt * 100.0):.4g} %",
)
