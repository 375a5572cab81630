# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The relay's thread: waits for messages and for deadlines at once, and serves both.

One thread owns all links. It sleeps in a wait set until a message comes in or shortly before the
next one is due, then to the deadline itself on the clock; no executor is involved. Other threads
talk to it only by :meth:`Relay.change`.
"""

import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import ExitStack

from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node

from pmwvc_core.errors import PmwvcError
from pmwvc_core.params import LinkParams
from pmwvc_core.runtime.pacing import sleep_until
from pmwvc_core.runtime.real_time import RealTimeReport, request_real_time
from pmwvc_core.runtime.topics import Polled
from pmwvc_netem.relayed_link import RelayedLink

FINE_NS = 150_000  # the last bit before a deadline is slept on the clock
LONGEST_WAIT_NS = 50_000_000  # a stop is seen this late
PRIORITY = 20


class Relay:
    """All links, and the loop that serves them.

    ``report`` is called after each round with the time, and returns when it wants to be called
    again [ns].
    """

    def __init__(
        self,
        node: Node,
        links: Sequence[RelayedLink],
        inlets: Sequence[Polled],
        report: Callable[[int], int],
    ) -> None:
        self.links = {relayed.name: relayed for relayed in links}
        self.memory = RealTimeReport()  # granted before the start
        self.real_time: RealTimeReport | None = None
        self._handles = [inlet.subscription.handle for inlet in inlets]
        self._report = report
        self._changes: deque[tuple[str, LinkParams]] = deque()
        self._guard = node.create_guard_condition(lambda: None)
        self._wait_set = rclpy_implementation.WaitSet(
            len(self._handles), 1, 0, 0, 0, 0, node.context.handle
        )

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
                    self._configure(name, params)
                for relayed in self.links.values():
                    relayed.take_in()
                for relayed in self.links.values():
                    relayed.let_out()
                now_ns = time.monotonic_ns()
                if now_ns >= report_ns:
                    report_ns = self._report(now_ns)
                self._sleep(report_ns)

    def _configure(self, name: str, params: LinkParams) -> None:
        """Change a link's settings; a plug-in that cannot follow is a fault, and they stay."""
        link = self.links[name].link
        try:
            link.configure(params)
        except PmwvcError as error:
            link.faults.note(params.effects, error)

    def _sleep(self, report_ns: int) -> None:
        """Sleep until a message comes in, one is due, or a report is."""
        now_ns = time.monotonic_ns()
        dues = [
            due for relayed in self.links.values() if (due := relayed.link.next_due_ns) is not None
        ]
        due_ns = min(dues, default=now_ns + LONGEST_WAIT_NS)
        coarse_ns = min(due_ns - FINE_NS, report_ns, now_ns + LONGEST_WAIT_NS)
        if coarse_ns > now_ns:
            self._wait(coarse_ns - now_ns)
        elif due_ns - now_ns <= FINE_NS:
            sleep_until(due_ns)

    def _wait(self, timeout_ns: int) -> None:
        self._wait_set.clear_entities()
        for handle in self._handles:
            self._wait_set.add_subscription(handle)
        self._wait_set.add_guard_condition(self._guard.handle)
        self._wait_set.wait(timeout_ns)
