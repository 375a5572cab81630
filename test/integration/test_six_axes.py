# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Orientations of a live session: of a device behind topics, and of the hand of a page."""

import signal

import numpy as np
from geometry_msgs.msg import PoseStamped, WrenchStamped
from scipy.spatial.transform import Rotation
from support.peers import ros
from support.played_server import Server, master
from support.sessions import Running

from pmwvc_analysis.recording.reader import read_session
from pmwvc_core.params import ServerParams
from pmwvc_core.runtime import messages
from pmwvc_core.runtime.topics import WAVE_QOS
from pmwvc_msgs.msg import MasterTrace, Wave
from pmwvc_view.live.topics import PublishedHand

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
            for found in (waves, blocks):  # which a busy test may get late
                peer.until(lambda of=found: abs(np.dot(of[-1].orientation, q)) > 1.0 - 1e-12)
            for wrench in wrenches:
                assert abs(wrench.wrench.force.x) < 1e-9
            assert process.stop() == 0


STEP_RAD, STEPS, BACK_M = 0.004, 100, 0.02


def test_a_turn_of_a_page_reaches_the_orientation_of_the_avatar_and_the_recording(tmp_path):
    """Real nodes: page, master with its hand, emulator, server. Nothing turned before. Targets are
    best effort: those that the recorder got are among those given, in their order.
    """
    folder, lever_m = tmp_path / "session", ServerParams.lever_m
    settings = ("user1.operator.kind=remote", "task.kind=hold")
    words = [word for setting in settings for word in ("--set", setting)]
    with Running(folder, "lift_body", "--users", 1, "--duration", 250, *words) as session:
        with ros(domain=session.domain()) as peer:
            hand = PublishedHand(peer.node, "/user1", lever_m)
            blocks = peer.collect(MasterTrace, "/user1/trace")
            waves = peer.collect(Wave, "/user1/wave_down")
            peer.until(lambda: waves and blocks and blocks[-1].state == MasterTrace.COUPLED)
            peer.until(lambda: peer.node.count_subscribers("/user1/hand/target") == 1)
            assert abs(waves[-1].orientation[3]) > 1.0 - 1e-6
            start, turned, steps = list(blocks[-1].x[-6:]), 0.0, 0
            while turned < STEP_RAD * STEPS - 0.02:
                waves.clear()
                peer.until(lambda: len(waves) >= 2)
                steps += 1
                angle = STEP_RAD * min(STEPS, steps)
                hand.give([start[0] - BACK_M, *start[1:5], lever_m * angle])
                x, y, z, w = waves[-1].orientation
                turned = 2.0 * np.arctan2(z * np.sign(w), abs(w))
                assert steps < 100 * STEPS, turned
            assert abs(x) + abs(y) < 1e-3
        session.process.send_signal(signal.SIGINT)
        assert session.end() == 0, session.output()
    x, y, way = read_session(folder).targets["user1"].turn.T
    np.testing.assert_allclose([x, y], 0.0, atol=1e-9)
    np.testing.assert_allclose(way / STEP_RAD, np.round(way / STEP_RAD), atol=1e-6)
    assert (np.diff(way) >= 0.0).all()
    assert 0.0 < way[-1] <= STEP_RAD * STEPS + 1e-9
