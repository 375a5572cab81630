# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The order of packets: where it is kept, a later packet waits for an earlier one."""

from pmwvc_core.network.effects.record import Effect, Uniform, linux_effect
from pmwvc_core.network.in_flight import Fate
from pmwvc_core.params import LinkParams


class Order(Effect):
    """Keep the order of packets where ``keep_order`` is set, also against earlier settings."""

    def __init__(self, params: LinkParams, uniform: Uniform) -> None:
        super().__init__(params, uniform)
        self._latest_ns = 0  # of all that came in

    def arrives_ns(self, fate: Fate, due_ns: int) -> int:
        """Return the time of the latest packet before where that is later."""
        latest_ns = self._latest_ns = max(due_ns, self._latest_ns)
        return latest_ns if self.params.keep_order else due_ns


RECORD = linux_effect(
    name="order",
    words="A later packet waits for an earlier one.",
    linear="order",
    make=Order,
    parameters=("keep_order",),
    active=lambda params: True,
    random=False,
    off=False,
)
