# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The constant delay of a link."""

from pmwvc_core.network.effects.record import Effect, linux_effect
from pmwvc_core.network.in_flight import Fate


class Delay(Effect):
    """Add ``delay_s``."""

    def delay_s(self, fate: Fate) -> float:
        """Return the constant delay [s]."""
        return float(self.params.delay_s)


RECORD = linux_effect(
    name="delay",
    words="Every packet takes the same time.",
    make=Delay,
    parameters=("delay_s",),
    active=lambda params: True,
    random=False,
    label=lambda params: f"{float(params.delay_s * 1e3):.4g} ms",
    mean_s=lambda params: float(params.delay_s),
)
