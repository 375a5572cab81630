# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The loop's wires in ROS.

Private topics: for each user ``~/<user>/wave_up`` in and ``~/<user>/wave_down`` out, and
``~/trace``; with the node's own name these are ``/server/user1/wave_up`` and so on.
"""

import time
from collections.abc import Sequence

from rclpy.node import Node

from pmwvc_core.frame.server_step import ServerRow
from pmwvc_core.runtime import messages
from pmwvc_core.runtime.pacing import Tick
from pmwvc_core.runtime.polling import TRACE_QOS, WAVE_QOS, Polled, offered
from pmwvc_core.transport.packet import WavePacket
from pmwvc_server.loop import ServerLoop


class RosWires:
    """See :class:`pmwvc_server.loop.Wires`.

    Parameters
    ----------
    node
        The node that owns publishers and subscriptions.
    users
        Names of the users.
    dof, epoch
        Axes of the packets, and the epoch of this server.
    period_s
        Time step of the server [s].
    """

    def __init__(
        self, node: Node, users: Sequence[str], *, dof: int, epoch: int, period_s: float
    ) -> None:
        self._users = list(users)
        self._dof = dof
        self._epoch = epoch
        self._types = types = messages.live_types()
        self._up = [Polled(node, types.Wave, f"~/{user}/wave_up") for user in users]
        wave_qos, trace_qos = offered(WAVE_QOS, period_s), offered(TRACE_QOS, period_s)
        self._down = [
            node.create_publisher(types.Wave, f"~/{user}/wave_down", wave_qos) for user in users
        ]
        self._trace = node.create_publisher(types.ServerTrace, "~/trace", trace_qos)

    def take(self, user: int) -> list[WavePacket]:
        """Return a user's packets that have arrived since the last call."""
        packets = []
        while (msg := self._up[user].take()) is not None:
            packets.append(messages.read_wave(msg, self._dof))
        return packets

    def send(self, user: int, packet: WavePacket) -> None:
        """Publish a packet to a user."""
        msg = messages.wave(self._types, packet, time.time_ns(), dof=self._dof)
        self._down[user].publish(msg)

    def publish_trace(
        self, loop: ServerLoop, row: ServerRow, tick: Tick, compute_s: float
    ) -> None:
        """Publish the step just made."""
        x_s, xd_s, f_s, u_s, v_s, energy_u_s, energy_v_s, contact = zip(*row.ports, strict=True)
        self._trace.publish(
            messages.server_trace(
                self._types,
                stamp_ns=time.time_ns() - time.monotonic_ns() + tick.due_ns,
                start_ns=tick.due_ns,
                epoch=self._epoch,
                step=loop.protocol.steps,
                period=loop.period_s,
                dof=self._dof,
                users=self._users,
                x_o=row.x_o,
                xd_o=row.xd_o,
                target=row.target,
                x_s=x_s,
                xd_s=xd_s,
                f_s=f_s,
                u_s=u_s,
                v_s=v_s,
                state=row.state,
                contact=[bool(touching) for touching in contact],
                energy_u_s=energy_u_s,
                energy_v_s=energy_v_s,
                kinetic=row.kinetic,
                potential=row.potential,
                dissipated=row.dissipated,
                accounts=row.accounts,
                lateness=tick.lateness_ns * 1e-9,
                compute=compute_s,
            )
        )
