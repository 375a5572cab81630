# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The loop's wires in ROS: the packets' topics, and publishers for observers.

Relative topics: ``wave_up`` out, ``wave_down`` in, ``trace``; and for observers, at the
packet rate and with the names of CRTK, ``measured_cv`` (TwistStamped, velocity of the device)
and ``measured_cf`` (WrenchStamped, force of the device on the hand, ``-f_m``).
"""

import time
from typing import Any

from geometry_msgs.msg import TwistStamped, Vector3, WrenchStamped
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data

from pmwvc_core.controllers.library import record_of
from pmwvc_core.ends.forms import vector
from pmwvc_core.numeric import Value
from pmwvc_core.runtime import messages
from pmwvc_core.runtime.topics import RECORDED_QOS, WaveTopics, offered
from pmwvc_core.transport.admission import Admission
from pmwvc_master.blocks import Block
from pmwvc_master.devices import DeviceSample
from pmwvc_master.loop import MasterLoop
from pmwvc_master.settings import MasterSettings


class RosWires:
    """The link and the observers of a force loop."""

    def __init__(
        self, node: Node, settings: MasterSettings, *, epoch: int, hand_force_known: bool
    ) -> None:
        self._dof, self._epoch = settings.dof, epoch
        self._hand_force_known = hand_force_known
        self._types = messages.live_types()
        self.link = WaveTopics(
            node,
            self._types,
            incoming="wave_down",
            outgoing="wave_up",
            admission=Admission(settings.token, out="up", into="down"),
            dof=settings.dof,
            extra=record_of(settings.controller).extra(settings.dof)[1],
            period_s=settings.master.frame_s,
        )
        trace_qos = offered(RECORDED_QOS, settings.master.frame_s)
        self._trace = node.create_publisher(self._types.MasterTrace, "trace", trace_qos)
        sensor = qos_profile_sensor_data
        self._twist = node.create_publisher(TwistStamped, "measured_cv", sensor)
        self._wrench = node.create_publisher(WrenchStamped, "measured_cf", sensor)
        self._frame_id = f"{node.get_namespace().strip('/') or node.get_name()}/device"
        self._seq = 0

    def publish_trace(self, loop: MasterLoop, block: Block) -> None:
        """Publish the ticks of a frame."""
        self._seq += 1
        self._trace.publish(
            messages.master_trace(
                self._types,
                block.series(),
                taken=block.taken,
                changes=block.changes,
                stamp_ns=_ros_time(block.start_ns),
                start_ns=block.start_ns,
                epoch=self._epoch,
                seq=self._seq,
                first_tick=block.first_tick,
                period=loop.tick_s,
                dof=self._dof,
                state=block.state,
                reason=block.reason,
                missed=loop.missed,
                safety_events=loop.protocol.s.limits.events,
                hand_force_known=self._hand_force_known,
                energy=block.energy,
                accounts=block.accounts,
            )
        )

    def publish_motion(self, sample: DeviceSample, f: Value, due_ns: int) -> None:
        """Publish velocity and force of the device, where anybody subscribes."""
        if not (self._twist.get_subscription_count() or self._wrench.get_subscription_count()):
            return
        stamp = messages.time_message(self._types, _ros_time(due_ns))
        twist, wrench = TwistStamped(), WrenchStamped()
        for message in (twist, wrench):
            message.header.stamp = stamp
            message.header.frame_id = self._frame_id
        _fill(twist.twist.linear, vector(sample.xd, self._dof))
        _fill(wrench.wrench.force, vector(-f, self._dof))
        self._twist.publish(twist)
        self._wrench.publish(wrench)


def _fill(vector: Vector3, values: Any) -> None:
    for axis, value in zip("xyz", values, strict=False):
        setattr(vector, axis, float(value))


def _ros_time(monotonic_ns: int) -> int:
    """Return a time of the monotonic clock on the time line of ROS [ns]."""
    return time.time_ns() - time.monotonic_ns() + monotonic_ns
