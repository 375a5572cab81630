# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The network-emulation node: relays topics with delay, jitter, loss and a slow line; reports the
fates of packets in blocks (``netem/fates``).

It works above DDS: it adds a hop of its own (its timing error is published), and knows nothing of
what happens inside the network below. One thread owns all links. It sleeps in a wait set until a
message comes in or shortly before the next one is due, then to the deadline itself on the clock;
no executor is involved. Another one serves parameters and diagnostics.
"""

import sys
import threading
import time
from collections import deque
from collections.abc import Mapping
from contextlib import ExitStack
from functools import partial

from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy

from pmwvc_core.errors import PmwvcError
from pmwvc_core.network.link import Link
from pmwvc_core.params import LinkParams
from pmwvc_core.runtime import messages
from pmwvc_core.runtime.pacing import granted_words, hold_memory, request_real_time, sleep_until
from pmwvc_core.runtime.process import OK, WARN, publish_health, run_node
from pmwvc_core.runtime.topics import RECORDED_QOS, Polled
from pmwvc_msgs.msg import Wave
from pmwvc_netem.relayed_link import RelayedLink
from pmwvc_netem.settings import LinkSetup, declare_settings

DEPTH = 100  # a burst while the relay sleeps must not be lost by the relay
LATE_NS = 2_000_000  # a release this late is worth a warning
FINE_NS = 150_000  # the last bit before a deadline is slept on the clock
LONGEST_WAIT_NS = 50_000_000  # a stop is seen this late
PRIORITY = 20
FATES_NS = 100_000_000  # between two reports of fates
BLOCK = 64  # of them in a message


class Netem:
    """The node: settings, all links, the loop that serves them, and their reports."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._changes: deque[tuple[str, LinkParams]] = deque()
        self._guard = node.create_guard_condition(lambda: None)
        setups = declare_settings(node, self._change)
        self._changes.clear()  # the links begin with them
        made = [_relayed(node, setup) for setup in setups]
        self._links, inlets = [relayed for relayed, _ in made], [inlet for _, inlet in made]
        self._handles = [inlet.subscription.handle for inlet in inlets]
        self._wait_set = rclpy_implementation.WaitSet(
            len(self._handles), 1, 0, 0, 0, 0, node.context.handle
        )
        self._types = messages.live_types()
        self._fates = node.create_publisher(self._types.PacketFate, "netem/fates", RECORDED_QOS)
        self._faults: dict[str, int] = {}  # of plug-ins, reported already
        publish_health(node, self._health)
        self._real_time = hold_memory()

    def _change(self, name: str, params: LinkParams) -> None:
        """Have a link's settings changed by the thread that owns it."""
        self._changes.append((name, params))
        self._guard.trigger()

    def run(self, stop: threading.Event) -> None:
        """Relay until ``stop`` is set."""
        names = ", ".join(relayed.name for relayed in self._links)
        self._node.get_logger().info(f"relaying {len(self._links)} links: {names}")
        self._real_time |= request_real_time(PRIORITY)
        by_name = {relayed.name: relayed.link for relayed in self._links}
        with ExitStack() as held:
            for handle in (*self._handles, self._guard.handle):
                held.enter_context(handle)  # not destroyed while in use
            report_ns = 0
            while not stop.is_set():
                while self._changes:
                    name, params = self._changes.popleft()
                    try:
                        by_name[name].configure(params)
                    except PmwvcError as error:  # a plug-in cannot follow: the settings stay
                        by_name[name].faults.note(error, params.effects)
                for relayed in self._links:
                    relayed.take_in()
                for relayed in self._links:
                    relayed.let_out()
                now_ns = time.monotonic_ns()
                if now_ns >= report_ns:
                    report_ns = now_ns + FATES_NS
                    for relayed in self._links:
                        self._publish_fates(relayed)
                self._sleep(report_ns)

    def close(self) -> None:
        """Complete the record."""
        for relayed in self._links:
            relayed.end()
            self._publish_fates(relayed)

    def _sleep(self, report_ns: int) -> None:
        """Sleep until a message comes in, one is due, or a report is."""
        now_ns = time.monotonic_ns()
        dues = [due for relayed in self._links if (due := relayed.link.next_due_ns) is not None]
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

    def _publish_fates(self, relayed: RelayedLink) -> None:
        while len(relayed.fates):
            block, now_ns = relayed.fates.take(BLOCK), time.time_ns()
            fates = messages.packet_fates(self._types, stamp_ns=now_ns, link=relayed.name, **block)
            self._fates.publish(fates)

    def _health(self) -> tuple[int, str, Mapping[str, object]]:
        """Return what people should know, once a second."""
        late_ns = max((relayed.late_ns for relayed in self._links), default=0)
        values: dict[str, object] = {"release late max [us]": f"{late_ns / 1e3:.0f}"}
        failed = []
        for relayed in self._links:
            relayed.late_ns = 0
            c, faults = relayed.link.counters, relayed.link.faults.steps
            ways = f"in {c.in_count}, out {c.out_count}, lost {c.lost}, dropped {c.dropped}"
            values[relayed.name] = f"{ways}, in flight {c.queued}, invalid {relayed.invalid}"
            if faults:
                values[f"{relayed.name}: faults"] = relayed.link.failed
            if faults > self._faults.get(relayed.name, 0):
                self._faults[relayed.name] = faults
                failed.append(f"{relayed.name}: {relayed.link.failed}")
                self._node.get_logger().warning(failed[-1])
        values["real time"] = granted_words(self._real_time)
        if late_ns > LATE_NS:
            failed.append(f"messages went out up to {late_ns / 1e6:.1f} ms late")
        text = "; ".join(failed) or f"relaying {len(self._links)} links"
        return (WARN if failed else OK), text, values


def _relayed(node: Node, setup: LinkSetup) -> tuple[RelayedLink, Polled]:
    qos = QoSProfile(depth=DEPTH, reliability=ReliabilityPolicy.BEST_EFFORT)
    inlet = Polled(node, Wave, setup.source, qos, raw=True)
    outlet = node.create_publisher(Wave, setup.target, qos)
    record = node.create_publisher(Wave, messages.record_of(outlet.topic_name), RECORDED_QOS)

    def give(message: bytes) -> None:
        outlet.publish(message)
        record.publish(message)

    link = Link(setup.params, seed=setup.seed, direction=setup.seed[2])
    clock = time.monotonic_ns
    return RelayedLink(setup.name, link, take=inlet.take, give=give, clock=clock), inlet


main = partial(run_node, "netem", Netem)

if __name__ == "__main__":
    sys.exit(main())
