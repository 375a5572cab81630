# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Messages say what went into them, to rclpy and to rosbags alike; packets and stamped vectors as
bytes are the middleware's, and whatever comes is read or refused.
"""

import dataclasses
import struct
from pathlib import Path

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped, TwistStamped, WrenchStamped
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from pmwvc_core.network.in_flight import COLUMNS
from pmwvc_core.runtime import messages
from pmwvc_core.runtime.pacing import Tick
from pmwvc_core.runtime.topics import packet_of, wave_bytes
from pmwvc_core.transport.packet import FLAG_LEAVING, Receipt, WavePacket, refused, size_bytes
from pmwvc_master.blocks import FrameBlock
from pmwvc_master.devices import ros_topic as cdr

DEFINITIONS = Path(__file__).resolve().parents[2] / "pmwvc_msgs" / "msg"
STAMP_NS = 1_700_000_000_123_456_789
ENERGY = {"u_m": 1.0, "u_tx": 2.0, "v_rx": 3.0, "v_m": 4.0, "device": 5.0, "hand": 6.0}
LIVE = messages.live_types()


def typestore():
    store = get_typestore(Stores.ROS2_JAZZY)
    for file in DEFINITIONS.glob("*.msg"):
        store.register(get_types_from_msg(file.read_text(), f"pmwvc_msgs/msg/{file.stem}"))
    return store


STORE = typestore()
RECORDED = messages.types_from(STORE.types)


def a_packet(value=0.5):
    return WavePacket(7, 3, 10, 0.008, value, value * 2, 0.25, value * 3, 2, 9, 1, FLAG_LEAVING)


def a_block(ticks=8, dof=1, *, filled=None):
    """Fill a block with numbers that differ from field to field, tick to tick and axis to axis."""
    block = FrameBlock(dof)
    for k in range(ticks if filled is None else filled):
        values = [100.0 * field + 10.0 * k for field in range(8)]
        axes = values if dof == 1 else [value + np.arange(dof) for value in values]
        packets = [a_packet(), refused(Receipt.CORRUPTED)] if k == 1 else []
        block.put(Tick(k, 0, 0, 1_000_000 * k, 0), axes, 2_000_000 * k, 1000 * k, packets)
    return block


def master(types, block, *, dof=1):
    return messages.master_trace(
        types, block.series(), taken=block.taken, changes=5, stamp_ns=STAMP_NS, start_ns=5,
        epoch=2**64 - 1, seq=6, first_tick=48, period=0.001, dof=dof, state=3, reason="too fast",
        missed=1, safety_events=2, hand_force_known=True, energy=ENERGY,
        accounts={"velocity_filter": 0.5, "tank": np.array([0.25])},
    )  # fmt: skip


def server(types):
    one, two = np.array([1.0, 2.0, 3.0]), np.array([4.0, 5.0, 6.0])
    return messages.server_trace(
        types, stamp_ns=STAMP_NS, start_ns=5, epoch=9, step=4, period=0.008, dof=3,
        users=["user1", "user2"], x_o=0.0, xd_o=one, target=two, x_s=[one, 0.0], xd_s=[0.0, two],
        f_s=[0.0, 0.0], u_s=[0.0, 0.0], v_s=[0.0, 0.0], state=[2, 0], contact=[np.True_, False],
        energy_u_s=[np.array([0.25]), 0.5], energy_v_s=[0.0, 1.0], kinetic=np.array([2.0]),
        potential=0.5, dissipated=0.125, accounts={"ledger": np.array([1.5])},
        taken=[(1, 8, 2**64 - 1)], looked=70_000, changes=2, poses={"box": [1.0] * 7},
        contacts=[-1.0, 0.0, *[0.5] * 6], contained=3,
    )  # fmt: skip


def fates(types):
    columns = {  # of two packets
        "epoch": [2**64 - 1, 0], "seq": [1, 2], "bytes": [126, 126], "time_in_ns": [1, 2],
        "time_due_ns": [3, 0], "time_out_ns": [4, 0], "fate": [0, 1], "cause": [0, 1],
    }  # fmt: skip
    arrays = {name: np.array(columns[name], kind) for name, kind in COLUMNS.items()}
    head = {"stamp_ns": STAMP_NS, "link": "user1/up", "first": 65}
    return messages.packet_fates(types, **head, **arrays)


BUILDERS = {
    "pmwvc_msgs/msg/Wave": lambda types: messages.wave(types, a_packet(), STAMP_NS),
    "pmwvc_msgs/msg/MasterTrace": lambda types: master(types, a_block()),
    "pmwvc_msgs/msg/ServerTrace": server,
    "pmwvc_msgs/msg/PacketFate": fates,
}


# Lists of eight-byte numbers that are empty.
EMPTY = dict.fromkeys(BUILDERS, 0) | {"pmwvc_msgs/msg/Wave": 1, "pmwvc_msgs/msg/MasterTrace": 1}


@pytest.mark.parametrize("name", BUILDERS)
def test_each_side_reads_what_the_other_has_written(name):
    live, recorded = BUILDERS[name](LIVE), BUILDERS[name](RECORDED)
    live_bytes = serialize_message(live)
    recorded_bytes = bytes(STORE.serialize_cdr(recorded, name))
    # They differ in what fills gaps; rclpy counts one behind every empty list, and adds it up.
    assert 0 <= len(live_bytes) - len(recorded_bytes) <= 8 * EMPTY[name]
    assert deserialize_message(recorded_bytes, type(live)) == live
    live_bytes = live_bytes[: len(recorded_bytes)]
    again = STORE.serialize_cdr(STORE.deserialize_cdr(live_bytes, name), name)
    assert bytes(again) == recorded_bytes


@given(stamp_ns=st.integers(0, 2**31 * 10**9 - 1))
def test_a_time_keeps_its_nanoseconds(stamp_ns):
    assert messages.nanoseconds(messages.time_message(LIVE, stamp_ns)) == stamp_ns


@pytest.mark.parametrize(("dof", "filled"), [(1, 4), (3, 4), (3, 2)])
def test_a_block_is_row_major_by_tick_and_holds_what_was_written(dof, filled):
    block = a_block(4, dof, filled=filled)
    message = master(LIVE, block, dof=dof)
    for field, name in enumerate(("x", "xd", "f_h", "f_m", "f_applied", "u_m", "u_m_lp", "v_m")):
        expected = [100.0 * field + 10.0 * k + axis for k in range(filled) for axis in range(dof)]
        assert list(getattr(message, name)) == expected
    np.testing.assert_allclose(message.lateness, [0.0, 0.001, 0.002, 0.003][:filled], rtol=1e-6)
    np.testing.assert_allclose(message.compute, [0.0, 0.002, 0.004, 0.006][:filled], rtol=1e-6)
    assert list(message.looked) == [0, 1000, 2000, 3000][:filled]
    taken = message.taken_tick, message.taken_seq, message.taken_epoch
    assert [list(each) for each in taken] == [[1], [3], [7]]  # without the one refused


finite = st.floats(allow_nan=False, allow_infinity=False)


@st.composite
def packets(draw):
    count = draw(st.integers(1, 6))

    def value():
        if count == 1:
            return draw(finite)
        return np.array(draw(st.lists(finite, min_size=count, max_size=count)))

    whole = st.integers(-(2**63), 2**63 - 1)
    return WavePacket(
        epoch=draw(st.integers(0, 2**64 - 1)),
        seq=draw(st.integers(0, 2**32 - 1)),
        sent_ns=draw(whole),
        period=draw(finite),
        wave=value(),
        integral=value(),
        energy=draw(finite),
        position=value(),
        echo_seq=draw(st.integers(0, 2**32 - 1)),
        echo_sent_ns=draw(whole),
        echo_hold_ns=draw(whole),
        flags=draw(st.integers(0, 2**16 - 1)),
        orientation=draw(st.tuples(*[finite] * 4)) if count == 6 else (),
        session=draw(st.integers(0, 2**64 - 1)),
    )


@given(packet=packets())
def test_bytes_are_those_of_the_middleware_and_read_back(packet):
    dof = np.size(packet.wave)
    data = wave_bytes(packet, STAMP_NS, dof=dof)
    message = messages.wave(LIVE, packet, STAMP_NS, dof=dof)
    assert deserialize_message(data, LIVE.Wave) == message
    for source in (data, serialize_message(message)[: size_bytes(dof)]):
        for field in dataclasses.fields(packet):
            read, sent = getattr(packet_of(source), field.name), getattr(packet, field.name)
            np.testing.assert_array_equal(read, sent)


def test_a_float_stands_for_every_axis():
    packet = packet_of(wave_bytes(WavePacket(1, 1, 0, 0.1, 0.5, 0.0, 0.0, 2.0), 0, dof=3))
    np.testing.assert_array_equal(packet.wave, [0.5] * 3)
    np.testing.assert_array_equal(packet.position, [2.0] * 3)


@pytest.mark.parametrize("lengths", [(0, 0, 0), (3, 1, 1), (1, 2, 0), (6, 5, 4)])
def test_a_wave_whose_lengths_differ_is_malformed(lengths):
    fields = dict(zip(("wave", "integral", "position"), ([1.0] * n for n in lengths), strict=True))
    found = packet_of(serialize_message(LIVE.Wave(**fields)))
    assert found.refusal is Receipt.MALFORMED


@given(data=st.binary(max_size=400), packet=packets(), at=st.integers(0, 300))
def test_any_bytes_are_refused_or_read_as_the_middleware_reads_them(data, packet, at):
    whole = wave_bytes(packet, STAMP_NS, dof=np.size(packet.wave))
    assert packet_of(whole[: -1 - at % 100]).refusal is Receipt.MALFORMED
    changed = whole[:at] + data[: len(whole) - at] + whole[at + len(data) :]
    for each in (data, b"\x00\x01\x00\x00" + data, changed[: len(whole)]):
        found = packet_of(each)
        if found.refusal is None:
            message = deserialize_message(each, LIVE.Wave)
            for name in ("epoch", "seq", "sent_ns", "period", "wave", "integral", "position"):
                np.testing.assert_array_equal(getattr(found, name), getattr(message, name))
        else:
            assert found.refusal is Receipt.MALFORMED


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
    assert cdr.numbers_of(serialize_message(pose), 3) == (12_000_000_034, (0.1, -0.2, 1e-9))
    assert cdr.numbers_of(serialize_message(twist), 3)[1] == (-3.0, 4.0, float("inf"))


def test_big_endian_messages_are_read_too():
    message = struct.pack(">4B", 0, 0, 0, 0) + struct.pack(">iII4s", 1, 2, 4, b"abc\0")
    message += struct.pack(">3d", 5.0, 6.0, 7.0)
    assert cdr.numbers_of(message, 3) == (1_000_000_002, (5.0, 6.0, 7.0))


def test_a_message_that_is_cut_or_whose_length_lies_is_none():
    whole = serialize_message(stamped(PoseStamped, ""))
    assert len(whole) > 44
    assert {cdr.numbers_of(whole[:length], 3) for length in range(44)} == {None}
    assert cdr.numbers_of(whole[:12] + b"\xff" * 4 + whole[16:], 3) is None


def test_a_wrench_is_one_to_ros():
    message = deserialize_message(cdr.wrench((1.5, -2.0, 0.25)), WrenchStamped)
    force, torque = message.wrench.force, message.wrench.torque
    assert (force.x, force.y, force.z) == (1.5, -2.0, 0.25)
    assert (torque.x, torque.y, torque.z) == (0.0, 0.0, 0.0)
    assert message.header.frame_id == "" and message.header.stamp.sec > 1_600_000_000
