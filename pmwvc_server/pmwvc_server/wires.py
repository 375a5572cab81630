# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The loop's wires in ROS: the topics of each user's packets, the trace, and the scene as markers.

Private topics: for each user ``~/<user>/wave_up`` in and ``~/<user>/wave_down`` out, and
``~/trace``; with the node's own name these are ``/server/user1/wave_up`` and so on.
"""

import time
from collections.abc import Sequence
from typing import Any

from geometry_msgs.msg import Point, Vector3
from rclpy.node import Node
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from pmwvc_core.controllers.library import record_of
from pmwvc_core.frame import Presence
from pmwvc_core.numeric import Value, flatten
from pmwvc_core.runtime import messages
from pmwvc_core.runtime.topics import RECORDED_QOS, WaveTopics
from pmwvc_core.transport.packet import Admission
from pmwvc_server.loop import MadeStep, ServerLoop
from pmwvc_server.settings import ServerSettings


class RosWires:
    """The packets' topics and the trace of the server."""

    def __init__(self, node: Node, settings: ServerSettings, *, epoch: int) -> None:
        self._users = [user.name for user in settings.users]
        self._dof, self._epoch = settings.dof, epoch
        token = settings.token
        self._types = types = messages.live_types()
        self.links = [
            WaveTopics(
                node, types, incoming=f"~/{user}/wave_up", outgoing=f"~/{user}/wave_down",
                admission=Admission(token.of(user) if token else None, out="down", into="up"),
                dof=settings.dof, extra=record_of(settings.controller).extra(settings.dof)[0],
            )
            for user in self._users
        ]  # fmt: skip
        self._trace = node.create_publisher(types.ServerTrace, "~/trace", RECORDED_QOS)

    def publish_trace(self, loop: ServerLoop, step: MadeStep) -> None:
        """Publish a step."""
        tick = step.tick
        taken = [
            (user, packet.seq, packet.epoch)
            for user, arrived in enumerate(step.packets)
            for packet in arrived
            if not packet.refusal
        ]
        message = messages.server_trace(
            self._types, stamp_ns=time.time_ns() - time.monotonic_ns() + tick.due_ns,
            start_ns=tick.due_ns, epoch=self._epoch, step=loop.protocol.steps,
            period=loop.protocol.p.period_s, dof=self._dof, users=self._users,
            lateness=tick.lateness_ns * 1e-9, compute=step.compute_s,
            looked=step.looked_ns - tick.due_ns, taken=taken, changes=loop.protocol.changes,
            **step.row._asdict(),
        )  # fmt: skip
        self._trace.publish(message)


FRAME = "world"
AVATAR_M = 0.012  # diameter
ARROW_M_PER_N = 0.02
# Okabe and Ito's colours: distinguished by colour-blind people too.
COLORS = (
    (0.00, 0.45, 0.70), (0.84, 0.37, 0.00), (0.00, 0.62, 0.45), (0.80, 0.47, 0.65),
    (0.90, 0.62, 0.00), (0.34, 0.71, 0.91), (0.94, 0.89, 0.26), (0.00, 0.00, 0.00),
)  # fmt: skip


def markers(loop: ServerLoop, users: Sequence[str], *, size_m: float, stamp: Any) -> MarkerArray:
    """Return the scene after the last step: an object with edges of ``size_m`` [m], its target,
    the avatars and their forces on it. Axes that there are not are drawn at zero.
    """
    row = loop.protocol.row()
    cube = _marker("object", 0, Marker.CUBE, stamp, (0.6, 0.6, 0.6), 0.8)
    cube.pose.position, cube.scale = _point(row.x_o), _size(size_m)
    target = _marker("target", 0, Marker.CUBE, stamp, (0.2, 0.7, 0.2), 0.25)
    target.pose.position, target.scale = _point(row.target), _size(1.02 * size_m)
    found = [cube, target]
    for user, name in enumerate(users):
        presence, color = row.state[user], COLORS[user % len(COLORS)]
        opacity = 0.4 if presence is Presence.DAMPING else 1.0
        avatar = _marker(f"{name}/avatar", user, Marker.SPHERE, stamp, color, opacity)
        force = _marker(f"{name}/force", user, Marker.ARROW, stamp, color, opacity)
        found += [avatar, force]
        if presence is Presence.ABSENT:
            avatar.action = force.action = Marker.DELETE
            continue
        x, f = flatten(row.x_s[user]), flatten(row.f_s[user])
        avatar.pose.position, avatar.scale = _point(x), _size(AVATAR_M)
        force.points = [_point(x), _point(x + f * ARROW_M_PER_N)]
        force.scale = Vector3(x=0.004, y=0.008, z=0.008)
    return MarkerArray(markers=found)


def _size(edge_m: float) -> Vector3:
    return Vector3(x=edge_m, y=edge_m, z=edge_m)


def _point(value: Value) -> Point:
    x, y, z = [*flatten(value), 0.0, 0.0][:3]
    return Point(x=float(x), y=float(y), z=float(z))


def _marker(
    namespace: str, number: int, kind: int, stamp: Any, color: Sequence[float], opacity: float
) -> Marker:
    marker = Marker(ns=namespace, id=number, type=kind, action=Marker.ADD)
    marker.header.frame_id, marker.header.stamp = FRAME, stamp
    marker.color = ColorRGBA(**dict(zip("rgba", (*color, opacity), strict=True)))
    return marker
