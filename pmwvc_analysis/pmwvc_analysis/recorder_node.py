# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The recorder: every topic of a session, as serialized messages, into a session folder.

It never decodes a message; it only reads the publishers' numbers, to know what is missing. It says
``ready`` on standard output once a publisher is matched on every topic it waits for.

What arrives waits in the subscriptions' queues, of ten thousand messages each, until this thread
takes it and has the disk. It runs above ordinary programs and below the loops: a busy machine
delays the recording and does not thin it out.
"""

import bisect
import sys
import threading
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from pmwvc_analysis.recording.reader import read_scenario
from pmwvc_analysis.recording.salvage import RawMessage
from pmwvc_analysis.recording.topics import Topic, about, session_topics
from pmwvc_analysis.recording.writer import RESERVE_BYTES, SessionWriter
from pmwvc_core.errors import ParameterError
from pmwvc_core.params import Validated
from pmwvc_core.params.fields import parameter
from pmwvc_core.runtime.messages import KEPT
from pmwvc_core.runtime.pacing import request_priority, request_reception
from pmwvc_core.runtime.parameters import declare, declare_names
from pmwvc_core.runtime.process import ERROR, OK, publish_health, run_node
from pmwvc_core.runtime.topics import Polled, message_class

POLL_S = 0.01  # far below what the subscriptions' queues hold
LINGER_S = 0.2  # after being asked to stop: what was just sent still arrives
GLOBAL = ("/diagnostics", "/parameter_events")  # whatever the namespace
# Below the loops whose packets these are; the middleware above what empties its queues.
RECEPTION_PRIORITY, PRIORITY = 5, 4


FLUSH_S = 1.0


@dataclass(frozen=True)
class RecorderParams(Validated):
    """The parameters of the node, beside the names of its users."""

    folder: str = parameter("", "-", "session folder to record into")
    netem: bool = parameter(True, "-", "the links are emulated: waves have a topic at either end")
    people: bool = parameter(
        True, "-", "also record markers, diagnostics and the targets of hands"
    )
    reserve_mib: int = parameter(
        RESERVE_BYTES >> 20, ">= 0 MiB", "space kept free: recording stops in good order there"
    )


class Recorder:
    """The work of the recorder node: from subscriptions into the file."""

    def __init__(self, node: Node) -> None:
        params, topics = declare_settings(node)
        self._ready = False
        self._writer = writer = SessionWriter(
            params.folder, reserve_bytes=params.reserve_mib << 20
        )
        for name, values in about(read_scenario(params.folder), source="live").items():
            writer.add_metadata(name, values)
        for topic in topics:
            writer.add_topic(topic)
        self._inlets = [(topic, _subscribed(node, topic)) for topic in topics]
        self._waiting: list[RawMessage] = []  # taken after the last look began
        self._newest_ns = {topic.name: 0 for topic in topics}
        publish_health(node, self._health)

    def run(self, stop: threading.Event) -> None:
        """Receive until asked to stop, and a little longer."""
        request_reception(RECEPTION_PRIORITY)
        request_priority(PRIORITY)
        reported, flush_at, writer = False, time.monotonic(), self._writer
        while not stop.wait(POLL_S):
            self._take_all()
            if time.monotonic() >= flush_at:
                flush_at = time.monotonic() + FLUSH_S
                writer.flush()
                writer.refresh_metadata()
            needed = (each.subscription for topic, each in self._inlets if topic.essential)
            if not self._ready and all(each.get_publisher_count() > 0 for each in needed):
                self._ready = True
                print("ready", flush=True)
            if not reported and writer.problem:
                reported = True
                elsewhere = f"report it with: pmwvc report {writer.folder} --out OTHER"
                print(f"recorder: {writer.problem}; {elsewhere}", file=sys.stderr, flush=True)
        until = time.monotonic() + LINGER_S
        while self._take_all() or time.monotonic() < until:
            time.sleep(POLL_S)

    def close(self) -> None:
        """Complete the recording and log what is missing."""
        self._write(self._waiting)
        self._writer.close()
        if self._writer.problem:
            lost = f"{self._writer.problem}; {self._writer.refused} messages not written"
            print(f"recorder: {lost}", file=sys.stderr)

    def _write(self, messages: Sequence[RawMessage]) -> None:
        for topic, _, log_ns, publish_ns, data in messages:
            self._writer.write(topic, data, log_ns=log_ns, publish_ns=publish_ns)

    def _take_all(self) -> int:
        """Take whatever has arrived; return how many messages.

        Topic after topic is emptied, the file is in the order of reception: what came in meanwhile
        waits for the next time. What was sent again counts as received before what waited for it.
        """
        before_ns = time.time_ns()
        count = len(self._waiting)
        for topic, inlet in self._inlets:
            take = inlet.subscription.handle.take_message
            while (got := take(inlet.kind, True)) is not None:
                data, info = got
                log_ns = int(info["received_timestamp"]) or time.time_ns()
                log_ns = self._newest_ns[topic.name] = max(log_ns, self._newest_ns[topic.name])
                times_ns = log_ns, int(info["source_timestamp"]) or log_ns
                found = RawMessage(topic.name, topic.type_name, *times_ns, bytes(data))
                self._waiting.append(found)
        taken = len(self._waiting) - count
        self._waiting.sort(key=lambda message: message.log_ns)
        ready = bisect.bisect_right(self._waiting, before_ns, key=lambda message: message.log_ns)
        self._write(self._waiting[:ready])
        del self._waiting[:ready]
        return taken

    def _health(self) -> tuple[int, str, Mapping[str, object]]:
        """Return what people should know, once a second."""
        writer, written = self._writer, sum(self._writer.messages.values())
        values: dict[str, object] = {"messages": written, "refused": writer.refused}
        if writer.problem:
            return ERROR, writer.problem, values
        return OK, "recording" if self._ready else "waiting for publishers", values


def declare_settings(node: Node) -> tuple[RecorderParams, list[Topic]]:
    """Declare the parameters; return them with the topics to record."""
    params = declare(node, "", RecorderParams)
    users = declare_names(node, "users", ["user1", "user2"], "names of the users")
    if not params.folder:
        raise ParameterError("folder is empty: name the session folder to record into")
    if not users:
        raise ParameterError("users is empty: name at least one user")
    links = [f"{user}/{way}" for user in users for way in ("up", "down")] if params.netem else []
    return params, session_topics(users, links=links, people=params.people)


def _subscribed(node: Node, topic: Topic) -> Polled:
    policy = ReliabilityPolicy.RELIABLE if topic.reliable else ReliabilityPolicy.BEST_EFFORT
    kept = DurabilityPolicy.TRANSIENT_LOCAL if topic.latched else DurabilityPolicy.VOLATILE
    qos = QoSProfile(depth=KEPT, reliability=policy, durability=kept)
    # A session may be in a namespace, which is the recorder's, too; in the file it has none.
    name = topic.name if topic.name in GLOBAL else topic.source.lstrip("/")
    return Polled(node, message_class(topic.type_name), name, qos, raw=True)


main = partial(run_node, "recorder", Recorder)

if __name__ == "__main__":
    sys.exit(main())
