# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The runner's ROS node: checks the connections of the session's nodes, starts them together and
reads their status a few times per second.

Any program on the domain can publish on these topics: a message whose fields do not fit together
is skipped, and so is another publisher while the one that is followed goes on.
"""

import json
import math
import time
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from std_srvs.srv import Trigger

from pmwvc_bringup.session.terminal import user_words
from pmwvc_core.runtime.messages import nanoseconds
from pmwvc_core.runtime.misfits import misfit
from pmwvc_core.runtime.services import unmatched
from pmwvc_core.runtime.topics import Polled
from pmwvc_msgs.msg import MasterTrace, Reception, ServerTrace

NEWEST = QoSProfile(depth=4, reliability=ReliabilityPolicy.BEST_EFFORT)
STALE_S = 1.0
SERVICE_TIMEOUT_S = 5.0
FIRST_TICKS_TIMEOUT_S = 3.0
RATE_REPORTS = 12  # six seconds of them


class Monitor:
    """A session seen from outside."""

    def __init__(self, node: Node, users: Sequence[str]) -> None:
        self._node, self._users = node, list(users)
        self._masters = {u: Polled(node, MasterTrace, f"{u}/trace", NEWEST) for u in users}
        self._server = Polled(node, ServerTrace, "server/trace", NEWEST)
        links = QoSProfile(depth=4 * len(users), reliability=ReliabilityPolicy.BEST_EFFORT)
        ends = [f"{user}/reception" for user in users] + ["server/reception"]
        self._receptions = [Polled(node, Reception, end, links) for end in ends]
        self._seen: dict[str, tuple[float, Any]] = {}
        # Of a user's ticks, and of its packets: newest times [ns] and numbers.
        self._counts: dict[str, deque[tuple[int, int]]] = {}

    def unconnected(self, nodes: Sequence[str], topics: Sequence[str]) -> list[str]:
        """Return what is missing until nothing that is sent gets lost, as texts: ends that are not
        in the graph yet, then nodes that do not answer yet, then ends that these have not matched.
        """
        polled = [*self._masters.values(), self._server, *self._receptions]
        own, missing = [each.subscription.topic_name for each in polled], []
        for topic in topics:
            if not self._node.count_publishers(topic):
                missing.append(f"{topic}: no publisher")
            elif self._node.count_subscribers(topic) <= own.count(topic):  # without this node
                missing.append(f"{topic}: no subscriber")
        if missing:
            return missing
        answers = self._call(nodes, "matched")
        return [f"{name}: no answer yet" for name in nodes if name not in answers] or [
            f"{name}: {text}"
            for name, answer in answers.items()
            for text in unmatched(json.loads(answer), topics)
        ]

    def start(self, groups: Sequence[Sequence[str]]) -> list[str]:
        """Call ``start`` of nodes that wait for it, one group after the other, and wait for the
        first ticks of all masters: the time of a session counts from there. Return which nodes did
        not answer, as texts.
        """
        for nodes in groups:
            answers = self._call(nodes, "start")
            if late := [name for name in nodes if name not in answers]:
                return [f"{name}: no answer to a call of start" for name in late]
        until = time.monotonic() + FIRST_TICKS_TIMEOUT_S
        while time.monotonic() < until and any(user not in self._seen for user in self._masters):
            for user, polled in self._masters.items():
                self._take(user, polled)
            time.sleep(0.01)
        return []

    def _call(self, nodes: Sequence[str], service: str) -> dict[str, str]:
        """Call a service of several nodes at once; return the messages of those that answered."""
        clients = {name: self._node.create_client(Trigger, f"{name}/{service}") for name in nodes}
        until = time.monotonic() + SERVICE_TIMEOUT_S
        calls = {}
        for name, client in clients.items():
            if client.wait_for_service(max(until - time.monotonic(), 0.0)):
                calls[name] = client.call_async(Trigger.Request())
        while not all(call.done() for call in calls.values()) and time.monotonic() < until:
            rclpy.spin_once(self._node, timeout_sec=0.05)
        for client in clients.values():
            self._node.destroy_client(client)
        return {name: str(call.result().message) for name, call in calls.items() if call.done()}

    def status(self) -> list[str]:
        """Return the newest values of every user, in words."""
        for user, polled in self._masters.items():
            self._take(user, polled)
        self._take("server", self._server)
        for polled in self._receptions:
            while (received := polled.take()) is not None:
                self._seen[f"link {received.link}"] = (time.monotonic(), received)
        server = self._fresh("server")
        return [self._user(name, server) for name in self._users]

    def _user(self, name: str, server: ServerTrace | None) -> str:
        up, down = (self._fresh(f"link {name}/{way}") for way in ("up", "down"))
        packets_hz = ticks_hz = force_n = state = None
        if up is not None:
            packets_hz = self._rate(up.link, nanoseconds(up.stamp), up.accepted, RATE_REPORTS)
        delays = [way.delay_mean if way else math.nan for way in (up, down)]
        if (trace := self._fresh(name)) is not None:
            ticks_hz = self._rate(name, trace.start_ns, trace.first_tick - trace.missed, 2)
            force_n = trace.f_applied[-trace.dof] if trace.f_applied else None
            state = trace.state
        contacts = zip(server.users, server.contact, strict=True) if server is not None else ()
        delays_s = delays if all(map(math.isfinite, delays)) else None
        touches = dict(contacts).get(name, False)
        return user_words(name, ticks_hz, packets_hz, delays_s, force_n, state, touches)

    def _rate(self, name: str, at_ns: int, number: int, kept: int) -> float | None:
        """Return how much a count grows in a second, over the newest times that are ``kept``."""
        counts = self._counts.setdefault(name, deque(maxlen=kept))
        if not counts or counts[-1][0] < at_ns:
            counts.append((at_ns, number))
        (begin_ns, begin), (end_ns, end) = counts[0], counts[-1]
        return (end - begin) / (end_ns - begin_ns) * 1e9 if end_ns > begin_ns else None

    def _take(self, name: str, polled: Polled) -> None:
        """Take what has come; keep the newest message of the publisher that is followed."""
        while (message := polled.take()) is not None:
            followed = self._fresh(name)
            other = followed is not None and followed.epoch != message.epoch
            if not other and not misfit(polled.kind.__name__, message):
                self._seen[name] = (time.monotonic(), message)

    def _fresh(self, name: str) -> Any:
        at_s, message = self._seen.get(name, (0.0, None))
        return message if time.monotonic() - at_s < STALE_S else None


@contextmanager
def watching(users: Sequence[str]) -> Iterator[Monitor]:
    """Yield a monitor in a ROS context of its own; the environment must be that of the nodes."""
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    try:
        node = Node("runner", start_parameter_services=False, enable_rosout=False)
        try:
            yield Monitor(node, users)
        finally:
            node.destroy_node()
    finally:
        rclpy.try_shutdown()
