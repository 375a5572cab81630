# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The rate limit: a serial line with a queue before it."""

from collections import deque

from pmwvc_core.network.effects.record import Effect, LinkEffect, Uniform
from pmwvc_core.network.in_flight import Fate
from pmwvc_core.params import LinkParams


def line_bytes(size: int, params: LinkParams) -> int:
    """Return what a packet of a size takes on the line, headers and whole cells [byte]."""
    size += params.rate_overhead_bytes
    if params.rate_cell_bytes:
        cells = -(-size // params.rate_cell_bytes)
        size = cells * (params.rate_cell_bytes + params.rate_cell_overhead_bytes)
    return size


class SerialLine(Effect):
    """Send one packet after the other, 8 size/rate each; drop those that find the queue full."""

    def __init__(self, params: LinkParams, uniform: Uniform) -> None:
        super().__init__(params, uniform)
        self._free_ns = 0
        self._waiting: deque[tuple[int, int]] = deque()  # when it gets the line, bytes
        self._bytes = 0  # of those that wait

    def departs_ns(self, fate: Fate, ready_ns: int) -> int | None:
        """Return when the last bit is on its way; None where too much waits already."""
        params, waiting = self.params, self._waiting
        while waiting and waiting[0][0] <= ready_ns:
            self._bytes -= waiting.popleft()[1]
        size = line_bytes(fate.size, params)
        start_ns = max(ready_ns, self._free_ns)
        waits = start_ns > ready_ns
        if len(waiting) >= params.queue_packets:
            return None
        if waits and params.queue_bytes and self._bytes + size > params.queue_bytes:
            return None
        waiting.append((start_ns, size))
        self._bytes += size
        self._free_ns = start_ns + round(8e9 * size / params.rate_limit_bps)
        return self._free_ns


RECORD = LinkEffect(
    name="rate_limit",
    words="Packets wait for a line of limited rate.",
    make=SerialLine,
    linux=True,
    parameters=(
        "rate_limit_bps",
        "rate_overhead_bytes",
        "rate_cell_bytes",
        "rate_cell_overhead_bytes",
        "queue_packets",
        "queue_bytes",
    ),
    active=lambda params: params.rate_limit_bps > 0.0,
    random=False,
    amount=lambda params: f"rate limit of {params.rate_limit_bps:g} bit/s",
    label=lambda params: f"{float(params.rate_limit_bps / 1e3):.4g} kbit/s",
    off=0,
)
