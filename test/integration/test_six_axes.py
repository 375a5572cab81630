# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A device behind topics along six axes: its orientation in, a torque out."""

import numpy as np
from geometry_msgs.msg import PoseStamped, WrenchStamped
from scipy.spatial.transform import Rotation
from support.played_server import Server, master
from support.processes import ros

from pmwvc_core.runtime import messages
from pmwvc_core.runtime.topics import WAVE_QOS

LEVER_M, TURN_RAD = 0.1, 0.01


def test_a_handle_that_turns_meets_a_torque_and_its_way_is_the_lever_times_its_turn():
    with ros() as peer:
        poses = peer.node.create_publisher(PoseStamped, "/user1/device/measured_cp", WAVE_QOS)
        wrenches = peer.collect(WrenchStamped, "/user1/device/servo_cf")
        parameters = {"device__plugin": "ros_topic", "server__lever_m": LEVER_M, "dof": 6}
        with master(peer, **parameters) as (process, blocks, waves):
            server, turns = Server(peer), 0
            peer.until(lambda: poses.get_subscription_count())
            while not any(wrench.wrench.torque.z < -0.01 for wrench in wrenches):
                waves.clear()
                peer.until(lambda: waves)
                turns += 1
                pose = PoseStamped()  # 1.25 rad/s by its stamps
                pose.header.stamp = messages.time_message(server.types, turns * 8_000_000)
                q = Rotation.from_rotvec([0.0, 0.0, turns * TURN_RAD]).as_quat().tolist()
                for name, each in zip("xyzw", q, strict=True):
                    setattr(pose.pose.orientation, name, each)
                poses.publish(pose)
                packet = server.packer.pack(np.zeros(6), np.zeros(6), turns)
                server.out.publish(messages.wave(server.types, packet, 0, dof=6))
            way = np.array([0.0] * 5 + [LEVER_M * TURN_RAD * (turns - 1)])
            peer.until(lambda: np.abs(np.array(blocks[-1].x)[-5:] - way[1:]).max() < 1e-9)
            waves.clear()
            peer.until(lambda: waves)
            for found in (waves[-1].orientation, blocks[-1].orientation):
                assert np.abs(np.dot(found, q)) > 1.0 - 1e-12
            for wrench in wrenches:
                assert abs(wrench.wrench.force.x) < 1e-9
            assert process.stop() == 0
