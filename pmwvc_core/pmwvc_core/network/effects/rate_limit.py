# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The rate limit: a serial line with a queue before it."""

from collections import deque

from pmwvc_core.network.effects.record import Effect, LinkEffect, Uniform
from pmwvc_core.network.in_flight import Fate
from pmwvc_core.params import LinkParams


class SerialLine(Effect):
    """Send one packet after the other, 8 size/rate each; drop those that find the queue full."""

    def __init__(self, params: LinkParams, uniform: Uniform) -> None:
        super().__init__(params, uniform)
        self._free_ns = 0
        self._starts_ns: deque[int] = deque()  # when each waiting packet gets the line

    def departs_ns(self, fate: Fate, ready_ns: int) -> int | None:
        """Return when the last bit is on its way; None where too many packets wait already."""
        starts = self._starts_ns
        while starts and starts[0] <= ready_ns:
            starts.popleft()
        if len(starts) >= self.params.queue_packets:
            return None
        start_ns = max(ready_ns, self._free_ns)
        starts.append(start_ns)
        self._free_ns = start_ns + round(8e9 * fate.size / self.params.rate_limit_bps)
        return self._free_ns


RECORD = LinkEffect(
    name="rate_limit",
    words="Packets wait for a line of limited rate.",
    make=SerialLine,
    parameters=("rate_limit_bps", "queue_packets"),
    active=lambda params: params.rate_limit_bps > 0.0,
    random=False,
    amount=lambda params: f"rate limit of {params.rate_limit_bps:g} bit/s",
    label=lambda params: f"{float(params.rate_limit_bps / 1e3):.4g} kbit/s",
    off=0,
)
