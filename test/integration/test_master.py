# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The master node as a process of its own; the test plays the server."""

import math

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, TwistStamped, WrenchStamped
from std_msgs.msg import Bool
from std_srvs.srv import Trigger
from support.peers import ros
from support.played_server import FRAME_S, MODULE, STEP_N, USER, Server, master, signal
from support.processes import NodeProcess

from pmwvc_core.params import MasterParams, OperatorParams
from pmwvc_core.runtime import messages
from pmwvc_core.runtime.topics import RECORDED_QOS, WAVE_QOS
from pmwvc_msgs.msg import MasterTrace, Reception, Wave

pytestmark = [pytest.mark.integration]

TICKS = MasterParams().rate_drop


def diagnosed(statuses, name):
    """The newest values of a node's health."""
    found = [s for array in statuses for s in array.status if s.name == name]
    return {pair.key: pair.value for pair in found[-1].values} if found else {}


@pytest.fixture(scope="module")
def alone():
    """What a master sent alone, its answers to changes of parameters, and its exit code."""
    with ros() as peer:
        blocks = []  # every one of them, which takes a reliable subscription
        peer.node.create_subscription(MasterTrace, "/user1/trace", blocks.append, RECORDED_QOS)
        with master(peer) as (process, _, waves):
            peer.until(lambda: len(blocks) > 150)
            peer.until(lambda: waves[-1].sent_ns > blocks[150].start_ns)
            changes = {"master.impedance": 10.0, "safety.max_force": 2.0}
            asked = [{"master.impedance": -3.0}, changes, {"master.rate_drop": 4}]
            reasons = [peer.set_parameters("/user1/master", values) for values in asked]
            count = len(blocks)
            peer.until(lambda: len(blocks) > count + 20)
            return blocks, waves, reasons, process.stop()


def test_alone_it_renders_no_force_and_does_not_move(alone):
    blocks, waves, _, code = alone
    assert {block.state for block in blocks} == {MasterTrace.STARTING}
    assert not signal(blocks, "f_applied").any()
    assert np.ptp(signal(blocks, "x")) == 0.0
    assert not any(any(wave.wave) for wave in waves)
    assert code == 0


def test_ticks_are_consecutive_and_every_frame_has_one_packet(alone):
    blocks, waves, *_ = alone
    ticks = np.concatenate([block.first_tick + np.arange(len(block.x)) for block in blocks])
    missed = blocks[-1].missed - blocks[0].missed
    assert np.all(np.diff(ticks) >= 1)
    assert ticks[-1] - ticks[0] + 1 == len(ticks) + missed
    assert np.all(np.diff([block.seq for block in blocks]) == 1)
    begin, end = blocks[50].start_ns, blocks[150].start_ns
    numbers = [wave.seq for wave in waves if begin < wave.sent_ns < end]
    assert np.all(np.diff(numbers) >= 1)
    frames = round((end - begin) * 1e-9 / FRAME_S)
    sent = numbers[-1] - numbers[0] + 1  # one that a busy test did not get was sent all the same
    assert abs(sent - frames) <= 1 + missed


def test_a_parameter_changes_while_it_runs_or_is_refused_with_the_reason(alone):
    (wrong,), changed, (fixed,) = alone[2]
    assert "master.impedance" in wrong and "0.01" in wrong and "1000" in wrong
    assert changed == ["", ""]
    assert fixed != ""


def test_broken_packets_change_nothing_and_force_comes_with_the_server_and_turns_to_damping():
    with ros() as peer, master(peer) as (process, blocks, waves):
        statuses = peer.collect(DiagnosticArray, "/diagnostics")
        server = Server(peer)
        for _ in range(3):
            server.send(wave=[math.nan])
            server.send(wave=[math.inf])
            server.send(**{name: [0.1, 0.2] for name in ("wave", "integral", "position")})
            server.send(wave=[])
            server.send(period=0.5)
            server.send(seq=0)
            blocks.clear()
            peer.until(lambda: blocks)  # its queue holds ten
        expected = {"not finite": "6", "wrong length": "3", "wrong period": "3", "malformed": "6"}
        peer.until(
            lambda: all(
                diagnosed(statuses, "/user1/master").get(f"packets {verdict}") == count
                for verdict, count in expected.items()
            )
        )
        assert {block.state for block in blocks} == {MasterTrace.STARTING}
        assert not signal(blocks, "f_applied").any()
        server.answer()
        server.send(wave=[math.nan])
        peer.until(lambda: diagnosed(statuses, "/user1/master")["packets new epoch"] == "1")
        assert process.process.poll() is None
        while not (signal(blocks, "f_applied") > 0.01).any():
            waves.clear()
            peer.until(lambda: waves)
            server.answer()
        assert any(block.state == MasterTrace.COUPLED for block in blocks)
        peer.until(lambda: blocks[-1].state == MasterTrace.DAMPING)
        assert np.abs(np.diff(signal(blocks, "f_applied"))).max() <= STEP_N
        seen = len(blocks)
        peer.until(lambda: not signal(blocks[-5:], "f_applied").any())  # let go in the end
        damping = [block for block in blocks[seen:] if block.state == MasterTrace.DAMPING]
        work = signal(damping, "f_applied") * signal(damping, "xd")
        assert work[TICKS * 4 :].min() >= 0.0  # takes energy only


def test_a_paused_master_waits_for_the_start():
    with ros() as peer:
        waves = peer.collect(Wave, "/user1/wave_up")
        received = peer.collect(Reception, "/user1/reception", reliable=True)
        health = peer.collect(DiagnosticArray, "/diagnostics", reliable=True)
        with NodeProcess(MODULE, {"start.paused": True}, arguments=USER):
            peer.until(lambda: len(health) == 3)  # 2 s: four reports of receivers, were it begun
            assert received == []
            response = peer.call(Trigger, "/user1/master/start", Trigger.Request())
            assert response.success
            first = peer.until(lambda: waves)[0]
            assert first.seq <= 2
            assert peer.until(lambda: received)[0].seq == 1


def test_a_runaway_device_is_left_without_force_until_rearmed():
    with ros() as peer:
        poses = peer.node.create_publisher(PoseStamped, "/user1/device/measured_cp", WAVE_QOS)
        twists = peer.node.create_publisher(TwistStamped, "/user1/device/measured_cv", WAVE_QOS)
        with master(peer, device__plugin="ros_topic") as (_, blocks, waves):
            server = Server(peer)
            peer.until(lambda: poses.get_subscription_count() and twists.get_subscription_count())

            def move_until(condition, velocity):
                """One sample of the device and one answer per packet, until it is so."""
                while not condition():
                    waves.clear()
                    peer.until(lambda: waves)
                    twist = TwistStamped()
                    twist.twist.linear.x = velocity
                    twists.publish(twist)
                    poses.publish(PoseStamped())
                    server.answer()

            def state_is(wanted):
                return lambda: blocks[-1].state == wanted

            move_until(state_is(MasterTrace.COUPLED), 0.02)
            assert blocks[-1].f_applied[-1] == pytest.approx(25.0 * 0.02, rel=0.05)
            move_until(state_is(MasterTrace.FAULT), 2.0)
            move_until(lambda: not signal(blocks[-3:], "f_applied").any(), 0.02)
            assert blocks[-1].state == MasterTrace.FAULT
            assert peer.call(Trigger, "/user1/master/rearm", Trigger.Request()).success
            count = len(blocks)
            move_until(state_is(MasterTrace.COUPLED), 0.02)
            force = signal(blocks[count:], "f_applied")
            assert np.abs(np.diff(force)).max() <= STEP_N


def test_a_device_behind_topics_gets_force_only_while_its_pose_is_fresh():
    with ros() as peer:
        poses = peer.node.create_publisher(PoseStamped, "/user1/device/measured_cp", WAVE_QOS)
        wrenches = peer.collect(WrenchStamped, "/user1/device/servo_cf")
        with master(peer, device__plugin="ros_topic") as (process, blocks, waves):
            server = Server(peer)
            peer.until(lambda: poses.get_subscription_count())
            x = 0.0

            def move():
                """One pose and one answer per packet of the master."""
                nonlocal x
                waves.clear()
                peer.until(lambda: waves)
                x += 0.0005
                pose = PoseStamped()  # 62.5 mm/s by its stamps, whenever this test gets to run
                pose.header.stamp = messages.time_message(server.types, round(x * 16e9))
                pose.pose.position.x = x
                poses.publish(pose)
                server.answer()

            assert not signal(blocks, "f_applied").any()
            while not any(wrench.wrench.force.x < -0.05 for wrench in wrenches):
                move()
            peer.until(lambda: blocks[-1].reason == "device silent: no force")
            assert blocks[-1].state == MasterTrace.DAMPING
            peer.until(lambda: not signal(blocks[-3:], "f_applied").any())
            assert not blocks[-1].hand_force_known
            assert process.stop() == 0


def test_a_remote_hand_follows_its_topic_and_lets_go_by_silence_held_and_nan():
    operator = OperatorParams(kind="remote")
    with ros() as peer, master(peer, operator=operator) as (_, blocks, waves):
        server = Server(peer)
        target = peer.node.create_publisher(PoseStamped, "/user1/hand/target", WAVE_QOS)
        held = peer.node.create_publisher(Bool, "/user1/hand/held", RECORDED_QOS)
        peer.until(target.get_subscription_count)
        peer.until(held.get_subscription_count)

        def answer_until(there, place=None):
            """Answer every packet, and publish a target with it, until something is so."""
            while not there():
                waves.clear()
                peer.until(lambda: waves)
                server.answer()
                if place is not None:
                    point = PoseStamped()
                    point.pose.position.x = place
                    target.publish(point)

        def free():
            """Whether a frame's hand force is that of the brake alone, which is left to nobody."""
            block = blocks[-1]
            brake = operator.remote.brake * np.array(block.xd)
            return np.abs(np.array(block.f_h) + brake).max() < 1e-9

        begin = blocks[-1].x[0]
        answer_until(lambda: blocks[-1].state == MasterTrace.COUPLED)
        answer_until(free)  # nobody holds
        answer_until(lambda: blocks[-1].x[0] > begin + 0.008, begin + 0.01)
        answer_until(free)  # silence
        answer_until(lambda: not free(), begin)
        held.publish(Bool(data=False))
        answer_until(free, begin)  # targets that go on coming do not count
        held.publish(Bool(data=True))
        answer_until(lambda: not free(), begin)
        answer_until(free, math.nan)
        assert np.abs(np.diff(signal(blocks, "f_applied"))).max() <= STEP_N
