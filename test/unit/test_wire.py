# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Packets as bytes: the same as the middleware's, and whatever comes is read or refused."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message

from pmwvc_core.runtime import messages
from pmwvc_core.runtime.topics import packet_of, wave_bytes
from pmwvc_core.transport.packet import Receipt, WavePacket

STAMP_NS = 1_700_000_000_123_456_789
LIVE = messages.live_types()
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
        session=draw(st.integers(0, 2**64 - 1)),
    )


def axes_of(packet):
    return np.size(packet.wave)


@given(packet=packets())
def test_bytes_are_those_of_the_middleware_and_read_back(packet):
    dof = axes_of(packet)
    data = wave_bytes(packet, STAMP_NS, dof=dof)
    message = messages.wave(LIVE, packet, STAMP_NS, dof=dof)
    assert deserialize_message(data, LIVE.Wave) == message
    for source in (data, serialize_message(message)):
        for field in dataclasses.fields(packet):
            read, sent = getattr(packet_of(source), field.name), getattr(packet, field.name)
            np.testing.assert_array_equal(read, sent)


def test_a_float_stands_for_every_axis():
    packet = packet_of(wave_bytes(WavePacket(1, 1, 0, 0.1, 0.5, 0.0, 0.0, 2.0), 0, dof=3))
    np.testing.assert_array_equal(packet.wave, [0.5] * 3)
    np.testing.assert_array_equal(packet.position, [2.0] * 3)


def test_what_is_not_a_number_is_read_as_it_is():
    packet = WavePacket(1, 1, 0, 0.1, math.nan, 0.0, 0.0, 0.0)
    assert math.isnan(packet_of(wave_bytes(packet, 0)).wave)


@pytest.mark.parametrize("lengths", [(0, 0, 0), (3, 1, 1), (1, 2, 0), (6, 5, 4)])
def test_a_wave_whose_lengths_differ_is_malformed(lengths):
    fields = dict(zip(("wave", "integral", "position"), ([1.0] * n for n in lengths), strict=True))
    found = packet_of(serialize_message(LIVE.Wave(**fields)))
    assert found.refusal is Receipt.MALFORMED


@given(data=st.binary(max_size=400), packet=packets(), at=st.integers(0, 300))
def test_any_bytes_are_refused_or_read_as_the_middleware_reads_them(data, packet, at):
    whole = wave_bytes(packet, STAMP_NS, dof=axes_of(packet))
    changed = whole[:at] + data[: len(whole) - at] + whole[at + len(data) :]
    for each in (data, b"\x00\x01\x00\x00" + data, changed[: len(whole)]):
        found = packet_of(each)
        if found.refusal is None:
            message = deserialize_message(each, LIVE.Wave)
            for name in ("epoch", "seq", "sent_ns", "period", "wave", "integral", "position"):
                np.testing.assert_array_equal(getattr(found, name), getattr(message, name))
        else:
            assert found.refusal is Receipt.MALFORMED


@given(packet=packets(), cut=st.integers(1, 100))
def test_a_message_that_is_cut_is_malformed(packet, cut):
    data = wave_bytes(packet, STAMP_NS, dof=axes_of(packet))
    assert packet_of(data[:-cut]).refusal is Receipt.MALFORMED
