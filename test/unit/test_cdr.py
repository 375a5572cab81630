# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Stamped vectors as bytes are what ROS makes of them, and the other way round."""

import struct

import pytest
from geometry_msgs.msg import PoseStamped, TwistStamped, WrenchStamped
from rclpy.serialization import deserialize_message, serialize_message

from pmwvc_master.devices import ros_topic as cdr


def stamped(kind, frame_id):
    message = kind()
    message.header.stamp.sec, message.header.stamp.nanosec = 12, 34
    message.header.frame_id = frame_id
    return message


@pytest.mark.parametrize("frame_id", ["", "b", "base", "base_link/tool", "äö" * 20])
def test_a_pose_and_a_twist_are_read_whatever_their_frame_is_called(frame_id):
    pose, twist = stamped(PoseStamped, frame_id), stamped(TwistStamped, frame_id)
    place, linear = pose.pose.position, twist.twist.linear
    place.x, place.y, place.z = 0.1, -0.2, 1e-9
    linear.x, linear.y, linear.z = -3.0, 4.0, float("inf")
    assert cdr.first_vector(serialize_message(pose)) == (12_000_000_034, (0.1, -0.2, 1e-9))
    assert cdr.first_vector(serialize_message(twist))[1] == (-3.0, 4.0, float("inf"))


def test_big_endian_messages_are_read_too():
    message = struct.pack(">4B", 0, 0, 0, 0) + struct.pack(">iII4s", 1, 2, 4, b"abc\0")
    message += struct.pack(">3d", 5.0, 6.0, 7.0)
    assert cdr.first_vector(message) == (1_000_000_002, (5.0, 6.0, 7.0))


@pytest.mark.parametrize("length", range(0, 44))
def test_a_message_that_is_cut_is_none(length):
    whole = serialize_message(stamped(PoseStamped, ""))
    assert len(whole) > 44
    assert cdr.first_vector(whole[:length]) is None


def test_a_length_that_lies_is_none():
    whole = bytearray(serialize_message(stamped(PoseStamped, "")))
    whole[12:16] = struct.pack("<I", 2**32 - 1)
    assert cdr.first_vector(bytes(whole)) is None


def test_a_wrench_is_one_to_ros():
    message = deserialize_message(cdr.wrench((1.5, -2.0, 0.25)), WrenchStamped)
    force, torque = message.wrench.force, message.wrench.torque
    assert (force.x, force.y, force.z) == (1.5, -2.0, 0.25)
    assert (torque.x, torque.y, torque.z) == (0.0, 0.0, 0.0)
    assert message.header.frame_id == "" and message.header.stamp.sec > 1_600_000_000
