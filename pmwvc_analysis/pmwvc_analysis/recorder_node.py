# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The recorder: every topic of a session, as serialized messages, into a session folder.

It never decodes a message; it only reads the publishers' numbers, to know what is missing. It says
``ready`` on standard output once a publisher is matched on every topic it waits for.
"""

import bisect
import importlib
import sys
import threading
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from pmwvc_analysis.recording.about import about
from pmwvc_analysis.recording.live import BackgroundWriter, Received
from pmwvc_analysis.recording.reader import read_scenario
from pmwvc_analysis.recording.topics import Topic, session_topics
from pmwvc_analysis.recording.writer import RESERVE_BYTES, SessionWriter
from pmwvc_core.errors import ParameterError
from pmwvc_core.params import Spec
from pmwvc_core.runtime.pacing import request_reception
from pmwvc_core.runtime.parameters import declare_names, declare_value
from pmwvc_core.runtime.polling import Polled
from pmwvc_core.runtime.process import ERROR, OK, publish_health, run_node

POLL_S = 0.005  # well below what the subscriptions' queues hold
LINGER_S = 0.2  # after being asked to stop: what was just sent still arrives
RECEPTION_PRIORITY = 5  # below the loops whose packets these are
GLOBAL = ("/diagnostics", "/parameter_events")  # whatever the namespace
DEPTH = 512  # about four seconds of a topic at the packet rate


class Recorder:
    """What the node does.

    Raises
    ------
    ParameterError, RecordingError
        If the folder or the users cannot be used.
    """

    def __init__(self, node: Node) -> None:
        folder, topics, reserve = declare_settings(node)
        self._ready = False
        writer = SessionWriter(folder, reserve_bytes=reserve)
        for name, values in about(read_scenario(folder), source="live").items():
            writer.add_metadata(name, values)
        for topic in topics:
            writer.add_topic(topic)
        self._background = BackgroundWriter(writer)
        self._inlets = [(topic, _subscribed(node, topic)) for topic in topics]
        self._waiting: list[Received] = []  # taken, but after the last look had begun
        publish_health(node, self._health)

    def run(self, stop: threading.Event) -> None:
        """Receive until asked to stop, and a little longer."""
        request_reception(RECEPTION_PRIORITY)
        told = False
        while not stop.wait(POLL_S):
            self._take_all()
            if not self._ready and self._all_matched():
                self._ready = True
                print("ready", flush=True)
            if not told and self._background.problem:
                told = True
                print(f"recorder: {self._background.problem}", file=sys.stderr, flush=True)
        until = time.monotonic() + LINGER_S
        while self._take_all() or time.monotonic() < until:
            time.sleep(POLL_S)

    def close(self) -> None:
        """Complete the recording and say what is missing."""
        for message in self._waiting:
            self._background.put(message)
        self._waiting.clear()
        for line in self._background.close():
            print(f"recorder: {line}", file=sys.stderr)

    def _take_all(self) -> int:
        """Take whatever has arrived; return how many messages.

        Topic after topic is emptied, the file is in the order of reception: what came in meanwhile
        waits for the next time.
        """
        before_ns = time.time_ns()
        count = len(self._waiting)
        for topic, inlet in self._inlets:
            handle = inlet.subscription.handle
            while (got := handle.take_message(inlet.kind, True)) is not None:
                data, info = got
                log_ns = int(info["received_timestamp"]) or time.time_ns()
                publish_ns = int(info["source_timestamp"]) or log_ns
                self._waiting.append(Received(topic.name, bytes(data), log_ns, publish_ns))
        taken = len(self._waiting) - count
        self._waiting.sort(key=lambda message: message.log_ns)
        ready = bisect.bisect_right(self._waiting, before_ns, key=lambda message: message.log_ns)
        for message in self._waiting[:ready]:
            self._background.put(message)
        del self._waiting[:ready]
        return taken

    def _all_matched(self) -> bool:
        return all(
            inlet.subscription.get_publisher_count() > 0
            for topic, inlet in self._inlets
            if topic.essential
        )

    def _health(self) -> tuple[int, str, Mapping[str, object]]:
        """Return what people should know, once a second."""
        writer = self._background.writer
        values = {"messages": sum(writer.counter.messages.values()), "refused": writer.refused}
        if self._background.problem:
            return ERROR, self._background.problem, values
        return OK, "recording" if self._ready else "waiting for publishers", values


def declare_settings(node: Node) -> tuple[Path, list[Topic], int]:
    """Declare the parameters; return folder, topics and bytes of disk to be kept free."""
    text = Spec(str, description="session folder to record into")
    folder = declare_value(node, "folder", text, "")
    users = declare_names(node, "users", ["user1", "user2"], "names of the users")
    relayed = Spec(bool, description="the links are emulated: waves have a topic at either end")
    people = Spec(bool, description="also record markers and diagnostics")
    space = Spec(
        int, "MiB", low=0, description="disk space kept free: recording stops in good order there"
    )
    emulated = declare_value(node, "netem", relayed, True)
    for_people = declare_value(node, "people", people, True)
    reserve = declare_value(node, "reserve_mib", space, RESERVE_BYTES >> 20)
    if not folder:
        raise ParameterError("folder is empty: name the session folder to record into")
    if not users:
        raise ParameterError("users is empty: name at least one user")
    links = [f"{user}/{way}" for user in users for way in ("up", "down")] if emulated else []
    return Path(folder), session_topics(users, links=links, people=for_people), reserve << 20


def _subscribed(node: Node, topic: Topic) -> Polled:
    policy = ReliabilityPolicy.RELIABLE if topic.reliable else ReliabilityPolicy.BEST_EFFORT
    qos = QoSProfile(depth=DEPTH, reliability=policy, durability=DurabilityPolicy.VOLATILE)
    # A session may be in a namespace, which is the recorder's, too; in the file it has none.
    name = topic.name if topic.name in GLOBAL else topic.name.lstrip("/")
    return Polled(node, _message_class(topic.type_name), name, qos, raw=True)


def _message_class(type_name: str) -> Any:
    package, _, name = type_name.partition("/msg/")
    return getattr(importlib.import_module(f"{package}.msg"), name)


def main(args: Sequence[str] | None = None) -> int:
    """Run the node and return its exit code."""
    return run_node("recorder", Recorder, args=args)


if __name__ == "__main__":
    sys.exit(main())
