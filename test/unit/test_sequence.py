# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Numbers of messages, and what is missing between them."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from pmwvc_analysis.recording import schemas
from pmwvc_analysis.recording.own import Decoded, Series, decoded
from pmwvc_core.network.in_flight import COLUMNS
from pmwvc_core.runtime import messages as build
from pmwvc_core.transport.packet import WavePacket

STORE = schemas.typestore()
TYPES = build.types_from(STORE.types)


def wave(seq, epoch=5):
    packet = WavePacket(epoch, seq, 10, 0.008, 0.5, 0.1, 0.2, 0.0)
    return bytes(STORE.serialize_cdr(build.wave(TYPES, packet, 12), schemas.WAVE))


def gaps(numbers):
    return Series(schemas.WAVE, [Decoded(0, None, *each) for each in numbers]).gaps()


@given(st.integers(0, 2**32 - 1), st.integers(0, 2**64 - 1))
def test_a_wave_has_epoch_and_number(seq, epoch):
    message = STORE.deserialize_cdr(wave(seq, epoch), schemas.WAVE)
    assert decoded(7, message, schemas.WAVE)[2:] == (f"{epoch:016x}", seq, 1)


@given(st.text("abcdefgh/12", min_size=0, max_size=12), st.integers(1, 2**40), st.integers(1, 9))
def test_fates_have_link_first_record_and_count(link, first, count):
    fields = dict.fromkeys(COLUMNS, np.arange(count))
    message = build.packet_fates(TYPES, stamp_ns=3, link=link, first=first, **fields)
    assert decoded(7, message, schemas.PACKET_FATE)[2:] == (link, first, count)


@given(st.lists(st.integers(1, 60), min_size=1, max_size=60, unique=True))
def test_gaps_are_what_is_not_there(numbers):
    absent = {*range(1, max(numbers) + 1)} - {*numbers}
    assert gaps(("a", number) for number in numbers) == {"a": (len(absent), len({*numbers}))}


def test_publishers_are_counted_apart():
    found = gaps((f"{epoch}", seq) for epoch, seq in ((1, 1), (1, 3), (2, 1), (2, 2)))
    assert found == {"1": (1, 2), "2": (0, 2)}
