# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Numbers read from the bytes of messages, and what is missing between them."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from pmwvc_analysis.recording import schemas
from pmwvc_analysis.recording.sequence import (
    MOST_STREAMS,
    GapCounter,
    Numbered,
    StreamCount,
    peek,
)
from pmwvc_core.network.in_flight import COLUMNS
from pmwvc_core.runtime import messages as build
from pmwvc_core.transport.packet import WavePacket

STORE = schemas.typestore()
TYPES = build.types_from(STORE.types)
UP = "/user1/wave_up"


def wave(seq, epoch=5):
    packet = WavePacket(epoch, seq, 10, 0.008, 0.5, 0.1, 0.2, 0.0)
    return bytes(STORE.serialize_cdr(build.wave(TYPES, packet, 12), schemas.WAVE))


@given(st.integers(0, 2**32 - 1), st.integers(0, 2**64 - 1), st.integers(0, 29))
def test_a_wave_shows_epoch_and_number_and_half_of_one_nothing(seq, epoch, length):
    data = wave(seq, epoch)
    assert peek(schemas.WAVE, data) == Numbered(f"{epoch:016x}", seq)
    assert peek(schemas.WAVE, data[:length]) is None
    peek(schemas.PACKET_FATE, data[:length])
    assert peek("std_msgs/msg/String", data) is None


@given(st.text("abcdefgh/12", min_size=0, max_size=12), st.integers(1, 2**40), st.integers(1, 9))
def test_fates_show_link_first_record_and_count(link, first, count):
    fields = dict.fromkeys(COLUMNS, np.arange(count))
    message = build.packet_fates(TYPES, stamp_ns=3, link=link, first=first, **fields)
    data = bytes(STORE.serialize_cdr(message, schemas.PACKET_FATE))
    assert peek(schemas.PACKET_FATE, data) == Numbered(link, first, count)


@given(st.lists(st.integers(1, 60), max_size=60, unique=True))
def test_gaps_are_what_is_not_there(numbers):
    stream = StreamCount()
    for number in numbers:
        stream.add(number, 1)
    absent = {*range(1, max(numbers, default=0) + 1)} - {*numbers}
    assert (stream.missing, stream.seen) == (len(absent), len({*numbers}))


def test_publishers_are_counted_apart_and_many_take_no_memory():
    counter = GapCounter()
    for epoch, seq in ((1, 1), (1, 3), (2, 1), (2, 2)):
        counter.add(UP, peek(schemas.WAVE, wave(seq, epoch)))
    assert (counter.messages, counter.missing(UP)) == ({UP: 4}, 1)
    (line,) = counter.lines()
    assert "1 of 3 missing" in line and f"{1:016x}" in line
    for epoch in range(10_000):
        counter.add(UP, peek(schemas.WAVE, wave(1, epoch)))
    assert counter.messages[UP] == 10_004
    assert len(counter.streams[UP]) <= MOST_STREAMS
