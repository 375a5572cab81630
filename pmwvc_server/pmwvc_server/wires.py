# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The loop's wires in ROS: the topics of each user's packets, and the trace.

Private topics: for each user ``~/<user>/wave_up`` in and ``~/<user>/wave_down`` out, and
``~/trace``; with the node's own name these are ``/server/user1/wave_up`` and so on.
"""

import time

from rclpy.node import Node

from pmwvc_core.controllers.library import record_of
from pmwvc_core.runtime import messages
from pmwvc_core.runtime.topics import RECORDED_QOS, WaveTopics, offered
from pmwvc_core.transport.admission import Admission
from pmwvc_server.loop import ServerLoop, Step
from pmwvc_server.settings import ServerSettings


class RosWires:
    """The packets' topics and the trace of the server."""

    def __init__(self, node: Node, settings: ServerSettings, *, epoch: int) -> None:
        self._users = [user.name for user in settings.users]
        self._dof, self._epoch = settings.dof, epoch
        token, period_s = settings.token, settings.server.period_s
        self._types = types = messages.live_types()
        self.links = [
            WaveTopics(
                node,
                types,
                incoming=f"~/{user}/wave_up",
                outgoing=f"~/{user}/wave_down",
                admission=Admission(token.of(user) if token else None, out="down", into="up"),
                dof=settings.dof,
                extra=record_of(settings.controller).extra(settings.dof)[0],
                period_s=period_s,
            )
            for user in self._users
        ]
        trace_qos = offered(RECORDED_QOS, period_s)
        self._trace = node.create_publisher(types.ServerTrace, "~/trace", trace_qos)

    def publish_trace(self, loop: ServerLoop, step: Step) -> None:
        """Publish a step."""
        tick = step.tick
        taken = [
            (user, packet.seq, packet.epoch)
            for user, arrived in enumerate(step.packets)
            for packet in arrived
            if not packet.refusal
        ]
        self._trace.publish(
            messages.server_trace(
                self._types,
                stamp_ns=time.time_ns() - time.monotonic_ns() + tick.due_ns,
                start_ns=tick.due_ns,
                epoch=self._epoch,
                step=loop.protocol.steps,
                period=loop.protocol.p.period_s,
                dof=self._dof,
                users=self._users,
                lateness=tick.lateness_ns * 1e-9,
                compute=step.compute_s,
                looked=step.looked_ns - tick.due_ns,
                taken=taken,
                changes=loop.protocol.changes,
                **step.row._asdict(),
            )
        )
