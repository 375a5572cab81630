# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A scaled device and its clutch at a master node: a driver of the laboratory publishes poses, the
test plays the server.
"""

import itertools
import time

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped, WrenchStamped
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_srvs.srv import SetBool
from support.peers import ros
from support.played_server import Server, master, signal

from pmwvc_core.master.safety import UNCOUPLED
from pmwvc_core.runtime import messages
from pmwvc_core.runtime.topics import WAVE_QOS

SCALE, PEAK_N, SLEW_N_S = 2.0, 3.0, 100.0
AXES = {"device__axes": "-x y z", "device__offset_x_m": 0.1}
SETTINGS = {
    "device__plugin": "ros_topic", "device__scale": SCALE, "safety__max_force": PEAK_N,
    "safety__max_slew": SLEW_N_S, "safety__soft_start_s": 0.05, "dof": 3, **AXES,
}  # fmt: skip
PRESSED_M, MOVED_M = 0.02, 0.05
# A test that stands still for some ticks shall not take them for a step of force.
EVERY_ONE = QoSProfile(depth=10_000, reliability=ReliabilityPolicy.BEST_EFFORT)
PATIENCE_S = 100.0  # a busy machine makes the device silent now and then


class Driver:
    """A driver: its handle creeps to where the test wants it, and is seen every 8 ms."""

    def __init__(self, peer, server, waves):
        self.peer, self.server, self.waves, self.x, self.count = peer, server, waves, 0.0, 0
        self.poses = peer.node.create_publisher(PoseStamped, "/user1/device/measured_cp", WAVE_QOS)
        peer.until(lambda: self.poses.get_subscription_count())

    def step(self):
        self.waves.clear()
        self.peer.until(lambda: self.waves)
        self.count += 1
        pose = PoseStamped()
        pose.header.stamp = messages.time_message(self.server.types, self.count * 8_000_000)
        pose.pose.position.x = self.x
        self.poses.publish(pose)
        packet = self.server.packer.pack(np.array([-0.7, 0.0, 0.0]), np.zeros(3), self.count)
        self.server.out.publish(messages.wave(self.server.types, packet, 0, dof=3))

    def until(self, there, x=None):
        end_s = time.monotonic() + PATIENCE_S
        while not there():
            assert time.monotonic() < end_s
            self.x += 0.0 if x is None else max(min(x - self.x, 2e-4), -2e-4)
            self.step()


def test_a_scaled_handle_is_let_go_moved_and_coupled_again_without_a_step():
    with ros() as peer:
        wrenches = []
        peer.node.create_subscription(
            WrenchStamped, "/user1/device/servo_cf", wrenches.append, EVERY_ONE
        )
        with master(peer, **SETTINGS) as (process, blocks, waves):
            driver = Driver(peer, Server(peer), waves)

            def at(x_m):
                return lambda: blocks and abs(blocks[-1].x[-3] - x_m) < 1e-9

            def pushed(x_n):
                return lambda: wrenches and abs(wrenches[-1].wrench.force.x - x_n) < 1e-9

            def clutch(pressed):
                request = SetBool.Request(data=pressed)
                assert peer.call(SetBool, "/user1/master/clutch", request).success

            away = 0.1 - SCALE * PRESSED_M
            driver.until(at(away), PRESSED_M)
            driver.until(pushed(PEAK_N))  # the peak of the device itself, along its own -x
            driver.until(lambda: abs(signal(blocks[-1:], "f_applied")[-3]) == PEAK_N / SCALE)
            clutch(True)
            driver.until(pushed(0.0))
            driver.until(lambda: driver.x == MOVED_M, MOVED_M)
            driver.until(at(away))
            driver.until(lambda: (blocks[-1].state, blocks[-1].reason) == (0, UNCOUPLED))
            clutch(False)
            driver.until(pushed(PEAK_N))
            driver.until(lambda: (blocks[-1].state, blocks[-1].reason) == (1, ""))
            driver.until(at(away))
            driver.until(at(away + SCALE * 0.01), MOVED_M - 0.01)
            assert process.stop() == 0
        x_m = signal(blocks, "x")[0::3]
        x_m = x_m[(abs(x_m - 0.1) > 1e-12).argmax() :]  # from the first motion on
        steps = abs(x_m[1:] - x_m[:-1])
        assert steps.max() < 0.1 * SCALE * (MOVED_M - PRESSED_M)  # some poses at once, no jump
        forces = [each.wrench.force.x for each in wrenches]
        changes = [abs(b - a) for a, b in itertools.pairwise(forces[:-1])]
        assert max(changes) < 0.5 * PEAK_N  # some ticks of the slew that were not seen
        assert max(abs(each) for each in forces) == pytest.approx(PEAK_N)
