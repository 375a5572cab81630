# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A device behind ROS topics: any driver that publishes its pose and takes a wrench.

Relative topics with the names of CRTK: ``device/measured_cp`` (PoseStamped) and, where there is
one, ``device/measured_cv`` (TwistStamped) in; ``device/servo_cf`` (WrenchStamped) out at every
tick: the force on the hand, ``-f_m``. Without a twist the velocity is the slope between the last
two poses, over the difference of their stamps.

A sample holds between messages, so the driver should publish about as fast as the loop runs. When
no finite pose has come for ``STALE_S`` the loop renders no force.
"""

from typing import Any

import numpy as np
from geometry_msgs.msg import PoseStamped, TwistStamped, WrenchStamped
from rclpy.qos import qos_profile_sensor_data

from pmwvc_core.errors import DeviceError
from pmwvc_core.numeric import Value, finite, flatten, signal
from pmwvc_core.runtime.messages import nanoseconds
from pmwvc_core.runtime.polling import Polled
from pmwvc_master.devices.interface import STALE_S, DeviceInfo, DeviceSample, DeviceSetup

_AXES = ("x", "y", "z")


class RosTopicDevice:
    """A device that another node drives; its hand's force is not known."""

    def __init__(self, setup: DeviceSetup) -> None:
        if setup.node is None:
            raise DeviceError(
                "device.plugin = 'ros_topic': needs a ROS node, so use the master node"
            )
        if setup.dof > len(_AXES):
            raise DeviceError(
                f"device.plugin = 'ros_topic': poses have {len(_AXES)} axes of motion; "
                f"set dof = {setup.dof} to {len(_AXES)} or less"
            )
        self.info = DeviceInfo(
            model="ROS topics", dof=setup.dof, pacing="event", velocity="estimated"
        )
        self._node = setup.node
        self._axes = _AXES[: setup.dof]
        self._zero = signal([0.0] * setup.dof, setup.dof)
        start = signal([setup.start_m, *[0.0] * (setup.dof - 1)], setup.dof)
        self._sample = DeviceSample(x=start, xd=self._zero, f_h=self._zero, valid=False)
        self._pose_ns: int | None = None
        self._stamp_ns = 0
        self._twist_ns: int | None = None

    def open(self) -> None:
        """Make publisher and subscriptions."""
        quality = qos_profile_sensor_data
        self._pose = Polled(self._node, PoseStamped, "device/measured_cp", quality)
        self._twist = Polled(self._node, TwistStamped, "device/measured_cv", quality)
        self._force = self._node.create_publisher(WrenchStamped, "device/servo_cf", quality)
        self._wrench = WrenchStamped()

    def read(self, due_ns: int) -> DeviceSample:
        """Take what has come since the last tick; say whether it is new."""
        sample = self._sample
        sample.fresh = False
        while (twist := self._twist.take()) is not None:
            velocity = self._vector(twist.twist.linear)
            if finite(velocity):
                sample.xd, self._twist_ns = velocity, due_ns
        while (pose := self._pose.take()) is not None:
            self._move(self._vector(pose.pose.position), nanoseconds(pose.header.stamp), due_ns)
        return sample

    def _move(self, x: Value, stamp_ns: int, now_ns: int) -> None:
        """Take a new position over; without a driver's velocity form one."""
        if not finite(x):
            return
        sample = self._sample
        if self._twist_ns is None or now_ns - self._twist_ns > STALE_S * 1e9:
            span_ns = stamp_ns - self._stamp_ns
            if self._pose_ns is None:  # the first pose says nothing of a velocity
                sample.xd = self._zero
            elif 0 < span_ns <= STALE_S * 1e9:
                sample.xd = (x - sample.x) / (span_ns * 1e-9)
            elif span_ns:
                sample.xd = self._zero
        sample.x, self._pose_ns, self._stamp_ns = x, now_ns, stamp_ns
        sample.valid = sample.fresh = True

    def _vector(self, message: Any) -> Value:
        return signal([getattr(message, axis) for axis in self._axes], len(self._axes))

    def write(self, f_m: Value) -> None:
        """Publish the force on the hand."""
        force = self._wrench.wrench.force
        for axis, value in zip(self._axes, flatten(f_m), strict=False):
            setattr(force, axis, -float(value))
        self._wrench.header.stamp = self._node.get_clock().now().to_msg()
        self._force.publish(self._wrench)

    def couple(self) -> None:
        """Do nothing: a person needs no start."""

    def stop(self) -> None:
        """Publish zero force."""
        self.write(np.zeros(len(self._axes)))

    def close(self) -> None:
        """Nothing to give back: the node owns publisher and subscriptions."""
