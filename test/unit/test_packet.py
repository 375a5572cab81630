# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Packets: numbers and running sums."""

from pathlib import Path

import numpy as np
import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from support.packer import Packer

from pmwvc_core.transport.packet import FLAG_DIRECT, FLAG_LEAVING, FLAG_LIMITED, size_bytes

MESSAGES = Path(__file__).resolve().parents[2] / "pmwvc_msgs" / "msg"


def test_numbers_count_from_one_and_the_sender_stays_the_same():
    packer = Packer(77, period=0.008)
    packets = [packer.pack(1.0, 0.0, 10 * n) for n in range(4)]
    assert [p.seq for p in packets] == [1, 2, 3, 4]
    assert [p.sent_ns for p in packets] == [0, 10, 20, 30]
    assert {p.epoch for p in packets} == {77}
    assert {p.period for p in packets} == {0.008}


def test_every_packet_contains_the_sums_of_all_before_it():
    packer = Packer(1, period=0.008)
    waves = [1.0, -2.0, 0.5]
    last = [packer.pack(w, 0.0, 0) for w in waves][-1]
    assert last.integral == pytest.approx(sum(waves) * 0.008)
    assert last.energy == pytest.approx(sum(w * w for w in waves) * 0.004)


def test_the_energy_of_several_axes_is_one_number():
    packer = Packer(1, period=0.02)
    packet = packer.pack(np.array([3.0, 4.0]), np.zeros(2), 0)
    np.testing.assert_allclose(packet.energy, 0.25)
    np.testing.assert_allclose(packet.integral, [0.06, 0.08])


def test_a_packet_sent_keeps_its_sums_when_more_are_sent():
    packer = Packer(1, period=0.5)
    first = packer.pack(np.array([1.0, 1.0]), np.zeros(2), 0)
    packer.pack(np.array([1.0, 1.0]), np.zeros(2), 0)
    np.testing.assert_array_equal(first.integral, [0.5, 0.5])


def test_flags_position_and_echo_travel_along():
    packet = Packer(1, period=0.008).pack(
        0.1, 0.25, 5, flags=FLAG_DIRECT | FLAG_LIMITED, echo=(9, 100, 3)
    )
    assert packet.position == 0.25
    assert packet.flags & FLAG_DIRECT and packet.flags & FLAG_LIMITED
    assert not packet.flags & FLAG_LEAVING
    assert (packet.echo_seq, packet.echo_sent_ns, packet.echo_hold_ns) == (9, 100, 3)


@pytest.mark.parametrize("extra", [0, 1, 12])
@pytest.mark.parametrize("dof", [1, 3, 6])
def test_the_size_is_that_of_the_serialized_message(dof, extra):
    store = get_typestore(Stores.ROS2_JAZZY)
    name = "pmwvc_msgs/msg/Wave"
    store.register(get_types_from_msg((MESSAGES / "Wave.msg").read_text(), name))
    time = store.types["builtin_interfaces/msg/Time"]
    values = np.ones(dof)
    message = store.types[name](
        stamp=time(sec=1, nanosec=2),
        sent_ns=3,
        epoch=4,
        seq=5,
        period=0.008,
        wave=values,
        integral=values,
        energy=0.0,
        position=values,
        extra=np.ones(extra),
        echo_seq=0,
        echo_sent_ns=0,
        echo_hold_ns=0,
        flags=0,
        check=0,
        session=0,
        tag=0,
    )
    assert size_bytes(dof, extra) == len(store.serialize_cdr(message, name))
