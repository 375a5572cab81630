# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The relay's thread: waits for messages and for deadlines at once, serves both, and reports the
fates of packets in blocks (``netem/fates``) and the state of its links (``netem/links``).

One thread owns all links. It sleeps in a wait set until a message comes in or shortly before the
next one is due, then to the deadline itself on the clock; no executor is involved. Other threads
talk to it only by :meth:`Relay.change`.
"""

import dataclasses
import threading
import time
from collections import deque
from collections.abc import Sequence
from contextlib import ExitStack

from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node

from pmwvc_core.errors import PmwvcError
from pmwvc_core.params import LinkParams
from pmwvc_core.runtime import messages
from pmwvc_core.runtime.pacing import sleep_until
from pmwvc_core.runtime.real_time import RealTimeReport, request_real_time
from pmwvc_core.runtime.topics import RECORDED_QOS, Polled
from pmwvc_netem.relayed_link import RelayedLink, Timing

FINE_NS = 150_000  # the last bit before a deadline is slept on the clock
LONGEST_WAIT_NS = 50_000_000  # a stop is seen this late
PRIORITY = 20
FATES_NS = 100_000_000
BLOCK = 64  # fates; a link with as many is not kept waiting for the time
STATES_NS = 250_000_000


class Relay:
    """All links, the loop that serves them, and their reports; ``memory`` is what was granted
    before the start.
    """

    def __init__(
        self, node: Node, links: Sequence[RelayedLink], inlets: Sequence[Polled], *, seed: int
    ) -> None:
        self.links = {relayed.name: relayed for relayed in links}
        self.memory = RealTimeReport()
        self.real_time: RealTimeReport | None = None
        self.worst_error_ns = 0  # latest release since somebody set this to zero
        self._seed = seed
        self._handles = [inlet.subscription.handle for inlet in inlets]
        self._changes: deque[tuple[str, LinkParams]] = deque()
        self._guard = node.create_guard_condition(lambda: None)
        self._wait_set = rclpy_implementation.WaitSet(
            len(self._handles), 1, 0, 0, 0, 0, node.context.handle
        )
        self._types = messages.live_types()
        self._fates = node.create_publisher(self._types.PacketFate, "netem/fates", RECORDED_QOS)
        self._states = node.create_publisher(self._types.LinkState, "netem/links", RECORDED_QOS)
        self._states_seq = 0
        self._fates_due_ns = self._states_due_ns = 0
        self._states_at_ns = time.monotonic_ns()

    def change(self, name: str, params: LinkParams) -> None:
        """Have a link's settings changed by the relay's thread."""
        self._changes.append((name, params))
        self._guard.trigger()

    def run(self, stop: threading.Event) -> None:
        """Relay until ``stop`` is set."""
        self.real_time = self.memory + request_real_time(PRIORITY)
        with ExitStack() as held:
            for handle in (*self._handles, self._guard.handle):
                held.enter_context(handle)  # not destroyed while in use
            report_ns = 0
            while not stop.is_set():
                while self._changes:
                    name, params = self._changes.popleft()
                    link = self.links[name].link
                    try:
                        link.configure(params)
                    except PmwvcError as error:  # a plug-in cannot follow: the settings stay
                        link.faults.note(params.effects, error)
                for relayed in self.links.values():
                    relayed.take_in()
                for relayed in self.links.values():
                    relayed.let_out()
                now_ns = time.monotonic_ns()
                if now_ns >= report_ns:
                    report_ns = self._report(now_ns)
                self._sleep(report_ns)

    def end(self) -> None:
        """Report the rest."""
        self._publish_states(time.monotonic_ns())
        for relayed in self.links.values():
            relayed.end()
            self._publish_fates(relayed)

    def _sleep(self, report_ns: int) -> None:
        """Sleep until a message comes in, one is due, or a report is."""
        now_ns = time.monotonic_ns()
        dues = [
            due for relayed in self.links.values() if (due := relayed.link.next_due_ns) is not None
        ]
        due_ns = min(dues, default=now_ns + LONGEST_WAIT_NS)
        coarse_ns = min(due_ns - FINE_NS, report_ns, now_ns + LONGEST_WAIT_NS)
        if coarse_ns > now_ns:
            self._wait_set.clear_entities()
            for handle in self._handles:
                self._wait_set.add_subscription(handle)
            self._wait_set.add_guard_condition(self._guard.handle)
            self._wait_set.wait(coarse_ns - now_ns)
        elif due_ns - now_ns <= FINE_NS:
            sleep_until(due_ns)

    def _report(self, now_ns: int) -> int:
        """Publish what is due; return when to be called again [ns]."""
        everything = now_ns >= self._fates_due_ns
        for relayed in self.links.values():
            if everything or len(relayed.fates) >= BLOCK:
                self._publish_fates(relayed)
        if everything:
            self._fates_due_ns = now_ns + FATES_NS
        if now_ns >= self._states_due_ns:
            self._publish_states(now_ns)
            self._states_due_ns = now_ns + STATES_NS
        return min(self._fates_due_ns, self._states_due_ns, now_ns + FATES_NS // 10)

    def _publish_fates(self, relayed: RelayedLink) -> None:
        while len(relayed.fates):
            block, stamp_ns = relayed.fates.take(BLOCK), time.time_ns()
            self._fates.publish(
                messages.packet_fates(self._types, stamp_ns=stamp_ns, link=relayed.name, **block)
            )

    def _publish_states(self, now_ns: int) -> None:
        self._states_seq += 1
        elapsed_s = (now_ns - self._states_at_ns) * 1e-9
        self._states_at_ns = now_ns
        for relayed in self.links.values():
            timing, relayed.timing = relayed.timing, Timing()
            self.worst_error_ns = max(self.worst_error_ns, timing.error_max_ns)
            self._states.publish(
                messages.link_state(
                    self._types,
                    stamp_ns=time.time_ns(),
                    link=relayed.name,
                    seq=self._states_seq,
                    counts=dataclasses.asdict(relayed.link.counters),
                    delays=timing.delays(),
                    rate_hz=timing.count / elapsed_s if elapsed_s > 0.0 else 0.0,
                    params=relayed.link.params,
                    seed=self._seed,
                )
            )
