# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Numbers read from the bytes of messages, and what is missing between them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pmwvc_analysis.recording import schemas
from pmwvc_analysis.recording.sequence import (
    MOST_RANGES,
    MOST_STREAMS,
    GapCounter,
    Numbered,
    StreamCount,
    peek,
)
from pmwvc_core.runtime import messages as build
from pmwvc_core.transport.packet import WavePacket

STORE = schemas.typestore()
TYPES = build.types_from(STORE.types)


def serialized(message, type_name):
    return bytes(STORE.serialize_cdr(message, type_name))


def wave(seq, epoch=5):
    packet = WavePacket(epoch, seq, 10, 0.008, 0.5, 0.1, 0.2, 0.0)
    return serialized(build.wave(TYPES, packet, 12), schemas.WAVE)


@given(st.integers(0, 2**32 - 1), st.integers(0, 2**64 - 1))
def test_a_wave_shows_epoch_and_number(seq, epoch):
    assert peek(schemas.WAVE, wave(seq, epoch)) == Numbered(f"{epoch:016x}", seq)


@given(st.text("abcdefgh/12", min_size=0, max_size=12), st.integers(1, 2**40), st.integers(1, 9))
def test_fates_show_link_first_record_and_count(link, first, count):
    row = np.arange(count)
    fields = {name: row for name in ("epoch", "seq", "bytes", "fate", "cause")}
    fields |= {name: row for name in ("time_in_ns", "time_due_ns", "time_out_ns")}
    message = build.packet_fates(TYPES, stamp_ns=3, link=link, first=first, **fields)
    data = serialized(message, schemas.PACKET_FATE)
    assert peek(schemas.PACKET_FATE, data) == Numbered(link, first, count)


@pytest.mark.parametrize("length", range(30))
def test_half_a_message_shows_nothing_and_does_no_harm(length):
    assert peek(schemas.WAVE, wave(1)[:length]) is None
    peek(schemas.PACKET_FATE, wave(1)[:length])
    peek("std_msgs/msg/String", wave(1)[:length])


@given(st.lists(st.integers(1, 60), max_size=80))
def test_gaps_are_what_is_not_there(numbers):
    stream = StreamCount()
    for number in numbers:
        stream.add(number, 1)
    there = set(numbers)
    absent = set(range(1, max(there, default=0) + 1)) - there
    assert stream.missing == len(absent)
    assert stream.seen == len(there)


def test_publishers_are_counted_apart():
    counter = GapCounter()
    for epoch, seq in ((1, 1), (1, 3), (2, 1), (2, 2)):
        counter.add("/user1/wave_up", peek(schemas.WAVE, wave(seq, epoch)))
    assert counter.messages == {"/user1/wave_up": 4}
    assert counter.missing("/user1/wave_up") == 1
    (line,) = counter.lines()
    assert "1 of 3 missing" in line
    assert f"{1:016x}" in line


def test_many_gaps_take_no_memory_and_are_all_counted():
    stream = StreamCount()
    for number in range(2, 40_001, 2):
        stream.add(number, 1)
    assert len(stream.ranges) <= MOST_RANGES
    assert (stream.seen, stream.missing) == (20_000, 20_000)
    stream.add(2, 1)
    assert (stream.seen, stream.missing) == (20_000, 20_000)


def test_a_stranger_with_a_new_epoch_in_every_message_takes_no_memory():
    counter = GapCounter()
    for epoch in range(10_000):
        counter.add("/user1/wave_up", peek(schemas.WAVE, wave(1, epoch)))
    assert counter.messages["/user1/wave_up"] == 10_000
    assert len(counter.streams["/user1/wave_up"]) <= MOST_STREAMS
