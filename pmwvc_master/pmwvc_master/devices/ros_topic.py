# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A device behind ROS topics: any driver that publishes its pose and takes a wrench.

Relative topics with the names of CRTK: ``device/measured_cp`` (PoseStamped) and, where there is
one, ``device/measured_cv`` (TwistStamped) in; ``device/servo_cf`` (WrenchStamped) out at every
tick: the force on the hand, ``-f_m``. Without a twist the velocity is the slope between the last
two poses, over the difference of their stamps.

A sample holds between messages, so the driver should publish about as fast as the loop runs. When
no finite pose has come for ``STALE_NS`` the loop renders no force.
"""

from geometry_msgs.msg import PoseStamped, TwistStamped, WrenchStamped
from rclpy.qos import qos_profile_sensor_data

from pmwvc_core.ends.forms import value, vector
from pmwvc_core.errors import DeviceError
from pmwvc_core.numeric import Value, finite
from pmwvc_core.runtime.topics import Polled
from pmwvc_master.devices import STALE_NS, DeviceInfo, DeviceSample, DeviceSetup
from pmwvc_master.devices.topics import MOST_AXES, first_vector, wrench


class RosTopicDevice:
    """A device that another node drives; its hand's force is not known."""

    def __init__(self, setup: DeviceSetup) -> None:
        if setup.node is None:
            raise DeviceError(
                "device.plugin = 'ros_topic': needs a ROS node, so use the master node"
            )
        if setup.dof > MOST_AXES:
            raise DeviceError(
                f"device.plugin = 'ros_topic': poses have {MOST_AXES} axes of motion; "
                f"set dof = {setup.dof} to {MOST_AXES} or less"
            )
        self.info = DeviceInfo(
            model="ROS topics", dof=setup.dof, pacing="event", velocity="estimated"
        )
        self._node, self._dof = setup.node, setup.dof
        self._zero = value((0.0,) * setup.dof)
        start = value((setup.start_m, *(0.0,) * (setup.dof - 1)))
        self._sample = DeviceSample(x=start, xd=self._zero, f_h=self._zero, valid=False)
        self._pose_ns: int | None = None
        self._stamp_ns = 0
        self._twist_ns: int | None = None

    def open(self) -> None:
        """Make publisher and subscriptions."""
        node, quality = self._node, qos_profile_sensor_data
        self._pose = Polled(node, PoseStamped, "device/measured_cp", quality, raw=True)
        self._twist = Polled(node, TwistStamped, "device/measured_cv", quality, raw=True)
        self._force = node.create_publisher(WrenchStamped, "device/servo_cf", quality)

    def read(self, due_ns: int) -> DeviceSample:
        """Take the samples since the last tick; the newest counts."""
        sample = self._sample
        sample.fresh = False
        while (message := self._twist.take()) is not None:
            twist = first_vector(message)
            if twist is not None and finite(velocity := value(twist[1][: self._dof])):
                sample.xd, self._twist_ns = velocity, due_ns
        while (message := self._pose.take()) is not None:
            pose = first_vector(message)
            if pose is not None:
                self._move(value(pose[1][: self._dof]), pose[0], due_ns)
        return sample

    def _move(self, x: Value, stamp_ns: int, now_ns: int) -> None:
        """Take a new position over; without a driver's velocity form one."""
        if not finite(x):
            return
        sample = self._sample
        if self._twist_ns is None or now_ns - self._twist_ns > STALE_NS:
            span_ns = stamp_ns - self._stamp_ns
            if self._pose_ns is None:  # the first pose gives no velocity
                sample.xd = self._zero
            elif 0 < span_ns <= STALE_NS:
                sample.xd = (x - sample.x) / (span_ns * 1e-9)
            elif span_ns:
                sample.xd = self._zero
        sample.x, self._pose_ns, self._stamp_ns = x, now_ns, stamp_ns
        sample.valid = sample.fresh = True

    def write(self, f_m: Value) -> None:
        """Publish the force on the hand."""
        if self._dof == 1:
            self._force.publish(wrench((-float(f_m), 0.0, 0.0)))
            return
        x, y, z = [*vector(-f_m, self._dof), 0.0][:3]
        self._force.publish(wrench((float(x), float(y), float(z))))

    def couple(self) -> None:
        """Do nothing: a person needs no start."""

    def stop(self) -> None:
        """Publish zero force."""
        self.write(self._zero)

    def close(self) -> None:
        """Nothing to give back: the node owns publisher and subscriptions."""
