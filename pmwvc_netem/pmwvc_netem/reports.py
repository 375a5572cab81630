# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The reports of the relay: fates of packets in blocks, and the state of its links.

Called by the relay's own thread; published on ``netem/fates`` and ``netem/links``.
"""

import dataclasses
import time
from collections.abc import Sequence

from rclpy.node import Node

from pmwvc_core.runtime import messages
from pmwvc_core.runtime.topics import RECORDED_QOS
from pmwvc_netem.relayed_link import RelayedLink, Timing

FATES_NS = 100_000_000
BLOCK = 64  # records; a link with as many is not kept waiting for the time
STATES_NS = 250_000_000


class Reports:
    """Publishers of fates and states."""

    def __init__(self, node: Node, links: Sequence[RelayedLink], *, seed: int) -> None:
        self.worst_error_ns = 0  # latest release since somebody set this to zero
        self._types = messages.live_types()
        self._fates = node.create_publisher(self._types.PacketFate, "netem/fates", RECORDED_QOS)
        self._states = node.create_publisher(self._types.LinkState, "netem/links", RECORDED_QOS)
        self._links = list(links)
        self._seed = seed
        self._seq = 0
        self._fates_due_ns = 0
        self._states_due_ns = 0
        self._states_at_ns = time.monotonic_ns()

    def __call__(self, now_ns: int) -> int:
        """Publish what is due; return when to be called again [ns]."""
        everything = now_ns >= self._fates_due_ns
        for relayed in self._links:
            if everything or len(relayed.fates) >= BLOCK:
                self._publish_fates(relayed)
        if everything:
            self._fates_due_ns = now_ns + FATES_NS
        if now_ns >= self._states_due_ns:
            self._publish_states(now_ns)
            self._states_due_ns = now_ns + STATES_NS
        return min(self._fates_due_ns, self._states_due_ns, now_ns + FATES_NS // 10)

    def end(self) -> None:
        """Publish the rest."""
        self._publish_states(time.monotonic_ns())
        for relayed in self._links:
            relayed.end()
            self._publish_fates(relayed)

    def _publish_fates(self, relayed: RelayedLink) -> None:
        while len(relayed.fates):
            block = relayed.fates.take(BLOCK)
            self._fates.publish(
                messages.packet_fates(
                    self._types, stamp_ns=time.time_ns(), link=relayed.name, **block
                )
            )

    def _publish_states(self, now_ns: int) -> None:
        self._seq += 1
        elapsed_s = (now_ns - self._states_at_ns) * 1e-9
        self._states_at_ns = now_ns
        for relayed in self._links:
            timing, relayed.timing = relayed.timing, Timing()
            self.worst_error_ns = max(self.worst_error_ns, timing.error_max_ns)
            self._states.publish(
                messages.link_state(
                    self._types,
                    stamp_ns=time.time_ns(),
                    link=relayed.name,
                    seq=self._seq,
                    counts=dataclasses.asdict(relayed.link.counters),
                    delays=timing.delays(),
                    rate_hz=timing.count / elapsed_s if elapsed_s > 0.0 else 0.0,
                    params=relayed.link.params,
                    seed=self._seed,
                )
            )
