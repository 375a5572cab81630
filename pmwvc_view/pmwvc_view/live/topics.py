# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The topics of a session: emptied into the feed of a page, and the hands of a page, published on
``hand/target`` and ``hand/held`` of each user.

Any program of the domain can publish on these topics: bytes that are no message, a message whose
fields do not fit together, or of another shape than the session's, are skipped.
"""

import json
import math
import time
from collections.abc import Iterable, Sequence
from contextlib import suppress
from typing import Any

import numpy as np
from geometry_msgs.msg import Point, PoseStamped, Quaternion
from rcl_interfaces.msg import ParameterEvent
from rclpy.node import Node
from rclpy.parameter import parameter_value_to_python
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from std_msgs.msg import Bool, String

from pmwvc_analysis.recording.assemble import server_traces, user_traces
from pmwvc_analysis.recording.clocks import monotonic_times
from pmwvc_core.numeric import Array
from pmwvc_core.quaternions import IDENTITY, carried
from pmwvc_core.runtime.messages import nanoseconds
from pmwvc_core.runtime.misfits import misfit
from pmwvc_core.runtime.topics import LATCHED_QOS, Polled
from pmwvc_core.traces import ServerTraces, UserTraces
from pmwvc_msgs.msg import MasterTrace, PacketFate, Reception, ServerTrace
from pmwvc_view.description import moving
from pmwvc_view.feed.feed import Feed
from pmwvc_view.feed.tape import NS, Tape
from pmwvc_view.live.graph import LOOK_S, Graph

SCENE_S = 5.0  # to get the description of a scene that is there
SAME_CLOCK_NS = 20_000_000  # clocks whose offsets differ by more are of two machines


class TraceReader:
    """The traces of a session with these users. ``clock_ns`` is by how much ROS time is ahead of
    the server's monotonic clock, as of the newest trace [ns]; None before.
    """

    def __init__(self, tape: Tape, *, dof: int) -> None:
        self._tape, self._dof, self._users = tape, dof, list(tape.users)
        self.clock_ns: int | None = None

    def of_master(self, name: str, every: Iterable[bytes]) -> UserTraces | None:
        """Return the traces of a master; None where all are skipped. One whose clock is of another
        machine is put beside the server's by ROS time, and its energy is not compared.
        """
        blocks = [message for data in every if (message := self._message(data, MasterTrace))]
        if not blocks:
            return None
        starts, ahead_ns = monotonic_times(blocks), _ahead_ns(blocks[-1])
        offset_ns = ahead_ns - (ahead_ns if self.clock_ns is None else self.clock_ns)
        elsewhere = abs(offset_ns) > SAME_CLOCK_NS
        starts = starts + offset_ns * elsewhere
        found, _ = user_traces(name, blocks, starts, zero_ns=self._tape.zero(int(starts.min())))
        if elsewhere:
            found.energy = {name: sums * math.nan for name, sums in found.energy.items()}
        return found

    def of_server(self, every: Iterable[bytes]) -> ServerTraces | None:
        """Return the traces of the server; None where all are skipped."""
        messages = (self._message(data, ServerTrace) for data in every)
        steps = [message for message in messages if message and message.users == self._users]
        if not steps:
            return None
        self.clock_ns, starts = _ahead_ns(steps[-1]), monotonic_times(steps)
        return server_traces(steps, starts, zero_ns=self._tape.zero(int(starts.min())))[0]

    def _message(self, data: bytes, kind: Any) -> Any:
        try:
            message = deserialize_message(data, kind)
        except (ValueError, RuntimeError):
            return None
        fits = message.dof == self._dof and misfit(kind.__name__, message) is None
        return message if fits and np.isfinite(message.lateness).all() else None


def _ahead_ns(message: Any) -> int:
    """Return by how much ROS time is ahead of the sender's monotonic clock [ns]."""
    return nanoseconds(message.stamp) - int(message.start_ns)


RELIABLE_QOS = QoSProfile(depth=256, reliability=ReliabilityPolicy.RELIABLE)
NEAR_NS = 60_000_000_000  # fates farther from the traces are of another machine's clock
AWAKE_S = 0.25  # longer between two looks, and this process stood still itself


class Inlets:
    """Subscriptions of a session; changed parameters are kept in its graph.

    ``round_trips`` are those that masters measured, by column [s], where no links tell more often;
    ``silent_s``: without a trace while this process ran [s]; ``changed``: a parameter was, since.
    """

    def __init__(self, node: Node, graph: Graph, reader: TraceReader) -> None:
        def polled(kind: Any, topic: str, *, raw: bool = False) -> Polled:
            return Polled(node, kind, topic, RELIABLE_QOS, raw=raw)

        self._graph, prefix = graph, graph.prefix
        links = (f"{user}/{way}" for user in graph.users for way in ("up", "down"))
        self._links = {link: number for number, link in enumerate(links)}  # of snapshots
        self._reader = reader
        self._masters = {
            user: polled(MasterTrace, f"{prefix}/{user}/trace", raw=True) for user in graph.users
        }
        self._steps = polled(ServerTrace, f"{prefix}/server/trace", raw=True)
        self._fates = polled(PacketFate, f"{prefix}/netem/fates")
        self._receptions = {
            user: polled(Reception, f"{prefix}/{user}/reception") for user in graph.users
        }
        self._events = polled(ParameterEvent, "/parameter_events")
        self.round_trips: dict[str, float] = {}
        self.silent_s, self._emptied_s = 0.0, time.monotonic()
        self.changed = False

    def now_ns(self) -> int:
        """Return the present time of the server's clock."""
        ahead_ns = self._reader.clock_ns
        return time.monotonic_ns() if ahead_ns is None else time.time_ns() - ahead_ns

    def empty(self, feed: Feed) -> None:
        """Give everything that has come to the feed."""
        received = False
        if (steps := self._reader.of_server(self._steps)) is not None:
            feed.on_server(steps)
            received = True
        for user, polled in self._masters.items():
            if (blocks := self._reader.of_master(user, polled)) is not None:
                feed.on_master(blocks)
                received = True
        before_s, self._emptied_s = self._emptied_s, time.monotonic()
        longer_s = min(self._emptied_s - before_s, AWAKE_S)
        self.silent_s = 0.0 if received else self.silent_s + longer_s
        zero_ns = feed.tape.zero_ns
        for message in self._fates:
            number = self._links.get(message.link)
            if number is None or misfit("PacketFate", message) or zero_ns is None:
                continue
            packets, age_ns = packets_of(message), abs(self.now_ns() - zero_ns)
            if len(packets) and abs(packets[-1, 1] - zero_ns) < NEAR_NS + age_ns:
                feed.on_packets(number, packets)
        for user, polled in self._receptions.items():
            for message in polled:
                if not self._graph.emulated:  # an emulator's packets tell more often
                    self.round_trips[f"{user}.round_trip"] = message.round_trip
        for event in self._events:
            known = self._graph.values.get(event.node)
            if known is not None:
                for each in event.changed_parameters:
                    known[each.name] = parameter_value_to_python(each.value)
                self.changed = True


def packets_of(message: Any) -> Array:
    """Return a PacketFate as packets: number, time in and out [ns], fate."""
    numbers = np.arange(message.first, message.first + len(message.time_in_ns), dtype=np.float64)
    return np.column_stack([numbers, message.time_in_ns, message.time_out_ns, message.fate])


def scene_of(node: Node, topic: str) -> dict[str, Any]:
    """Return how a server's environment describes itself on a latched topic; {}: not at all."""
    reader, came = Polled(node, String, topic, LATCHED_QOS), list[Any]()  # no executor uses it
    until_s = time.monotonic() + SCENE_S
    while node.count_publishers(topic) and not came and time.monotonic() < until_s:
        time.sleep(LOOK_S)
        came += reader
    node.destroy_subscription(reader.subscription)
    with suppress(LookupError, TypeError, ValueError):  # nothing came, or no description
        scene = dict(json.loads(came[0].data))
        moving(scene)
        return scene
    return {}


TARGET_QOS = QoSProfile(depth=4, reliability=ReliabilityPolicy.BEST_EFFORT)
HELD_QOS = QoSProfile(depth=4, reliability=ReliabilityPolicy.RELIABLE)
HELD_S = 0.13  # between two repetitions of what holds


def target_message(position: Sequence[float], q: Sequence[float], stamp_ns: int) -> PoseStamped:
    """Return a target [m], x y z w, as a message; axes that there are not are zero."""
    message = PoseStamped()
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp_ns, NS)
    message.pose.position = Point(**dict(zip("xyz", map(float, position), strict=False)))
    message.pose.orientation = Quaternion(**dict(zip("xyzw", q, strict=True)))
    return message


class PublishedHand:
    """The hand of one user, below the namespace ``topics``; it turns from the identity on."""

    def __init__(self, node: Node, topics: str, lever_m: float) -> None:
        self._lever_m, self._way, self._q = lever_m, np.zeros(3), tuple(IDENTITY)
        self._targets = node.create_publisher(PoseStamped, f"{topics}/hand/target", TARGET_QOS)
        self._flags = node.create_publisher(Bool, f"{topics}/hand/held", HELD_QOS)
        self._closed, self._flagged_s = False, -math.inf

    def give(self, position: Sequence[float] | None) -> None:
        """Publish a target; None opens the hand."""
        closed, self._closed = self._closed, position is not None
        if position is None:
            if closed:
                self._flags.publish(Bool(data=False))
            return
        now_s = time.monotonic()
        if not closed or now_s - self._flagged_s > HELD_S:  # one started meanwhile missed it
            self._flagged_s = now_s
            self._flags.publish(Bool(data=True))
        if len(way := np.array(position[3:])):
            self._q = carried(self._q, ((way - self._way) / self._lever_m).tolist())
            self._way = way
        self._targets.publish(target_message(position, self._q, time.time_ns()))
