# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The network-emulation node: relays topics with delay, jitter, loss and a slow line.

It works above DDS: it adds a hop of its own (its timing error is published), and knows nothing of
what happens inside the network below.
"""

import sys
import threading
import time
from collections.abc import Mapping
from functools import partial

from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy

from pmwvc_core.network.link import Link
from pmwvc_core.params import LinkParams
from pmwvc_core.runtime.messages import record_of
from pmwvc_core.runtime.process import OK, WARN, publish_health, run_node
from pmwvc_core.runtime.real_time import hold_memory
from pmwvc_core.runtime.topics import RECORDED_QOS, Polled
from pmwvc_core.runtime.watch import PATIENCE_S, nothing_on, publishers_of
from pmwvc_netem.relay import Relay
from pmwvc_netem.relayed_link import RelayedLink
from pmwvc_netem.settings import LinkSetup, Settings

DEPTH = 100  # a burst while the relay sleeps must not be lost by the relay
LATE_NS = 2_000_000  # a release this late is worth a warning


class Netem:
    """The node: settings, links and relay."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._relay: Relay | None = None
        self._settings = Settings(node, self._change)
        made = [_relayed(node, setup) for setup in self._settings.setups]
        self._links, inlets = [relayed for relayed, _ in made], [inlet for _, inlet in made]
        self._topics = [inlet.subscription.topic_name for inlet in inlets]
        self._relay = Relay(node, self._links, inlets, seed=self._settings.seed)
        self._publishers = publishers_of(node)
        self._faults: dict[str, int] = {}  # of plug-ins, reported already
        self._running_s: float | None = None  # since when
        publish_health(node, partial(self._health, self._relay))
        self._relay.memory = hold_memory()

    def run(self, stop: threading.Event) -> None:
        """Relay."""
        names = ", ".join(relayed.name for relayed in self._links)
        self._node.get_logger().info(f"relaying {len(self._links)} links: {names}")
        if self._relay is not None:
            self._relay.run(stop)

    def close(self) -> None:
        """Complete the record."""
        if self._relay is not None:
            self._relay.end()

    def _change(self, name: str, params: LinkParams) -> None:
        if self._relay is not None:
            self._relay.change(name, params)

    def _health(self, relay: Relay) -> tuple[int, str, Mapping[str, object]]:
        """Return what people should know, once a second."""
        late_ns, relay.worst_error_ns = relay.worst_error_ns, 0
        values: dict[str, object] = {"release late max [us]": f"{late_ns / 1e3:.0f}"}
        failed = []
        for relayed in self._links:
            c, faults = relayed.link.counters, relayed.link.faults
            ways = f"in {c.in_count}, out {c.out_count}, lost {c.lost}, dropped {c.dropped}"
            rest = f"in flight {c.queued}, invalid {relayed.invalid}"
            values[relayed.name] = f"{ways}, {rest}"
            if faults.count:
                values[f"{relayed.name}: faults"] = str(faults)
            if faults.count > self._faults.get(relayed.name, 0):
                self._faults[relayed.name] = faults.count
                failed.append(f"{relayed.name}: {faults}")
                self._node.get_logger().warning(failed[-1])
        values["real time"] = str(relay.real_time or "not requested yet")
        wrong = [*self._never_met(relay), *failed]
        if late_ns > LATE_NS:
            wrong.append(f"messages went out up to {late_ns / 1e6:.1f} ms late")
        if wrong:
            return WARN, "; ".join(wrong), values
        return OK, f"relaying {len(self._links)} links", values

    def _never_met(self, relay: Relay) -> list[str]:
        """Return the links into which nothing has come though the relay has run for a while."""
        if self._running_s is None:
            if relay.real_time is not None:
                self._running_s = time.monotonic()
            return []
        if time.monotonic() - self._running_s < PATIENCE_S:
            return []
        return [
            nothing_on(topic, sorted(self._publishers(topic)))
            for topic, relayed in zip(self._topics, self._links, strict=True)
            if not relayed.link.counters.in_count
        ]


def _relayed(node: Node, setup: LinkSetup) -> tuple[RelayedLink, Polled]:
    policy = ReliabilityPolicy.RELIABLE if setup.reliable else ReliabilityPolicy.BEST_EFFORT
    qos = QoSProfile(depth=DEPTH, reliability=policy)
    inlet = Polled(node, setup.kind, setup.source, qos, raw=True)
    outlet = node.create_publisher(setup.kind, setup.target, qos)
    outlets = [outlet]
    if setup.is_wave:
        record = record_of(outlet.topic_name)
        outlets.append(node.create_publisher(setup.kind, record, RECORDED_QOS))

    def give(message: bytes) -> None:
        for each in outlets:
            each.publish(message)

    relayed = RelayedLink(
        setup.name, Link(setup.params, seed=setup.seed, direction=setup.seed[2]), take=inlet.take,
        give=give, clock=time.monotonic_ns, is_wave=setup.is_wave,
    )  # fmt: skip
    return relayed, inlet


main = partial(run_node, "netem", Netem)

if __name__ == "__main__":
    sys.exit(main())
