# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The receiver under any packets at all, in any order."""

import dataclasses

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from support.packer import Packer

from pmwvc_core.numeric import finite
from pmwvc_core.transport.packet import LAST_NUMBER, Receipt
from pmwvc_core.transport.receiver import Receiver

PERIOD_S = 0.008
PERIOD_NS = 8_000_000
ACCEPTING = (Receipt.ACCEPTED, Receipt.NEW_EPOCH)

number, whole = st.floats(), st.integers(-(2**63), 2**63 - 1)
signal = st.one_of(
    number, st.lists(number, max_size=3).map(lambda values: np.array(values, float))
)
FIELDS = {  # whatever bytes can be read as
    **dict.fromkeys(("epoch", "seq", "echo_seq"), st.integers(0, 2**32)),
    **dict.fromkeys(("sent_ns", "echo_sent_ns", "echo_hold_ns"), whole),
    **dict.fromkeys(("period", "energy"), number),
    **dict.fromkeys(("wave", "integral", "position"), signal),
    **{"flags": st.integers(0, 2**16 - 1), "extra": st.lists(number, max_size=2).map(tuple)},
    "refusal": st.sampled_from((None, *Receipt)[3:]),
}


def stream(count):
    packer = Packer(1, period=PERIOD_S)
    return [packer.pack(float(n + 1), 0.0, n * PERIOD_NS) for n in range(count)]


def receiver(**settings):
    return Receiver(1, period_s=PERIOD_S, timeout_s=0.03, **settings)


@given(spoilt=st.lists(st.fixed_dictionaries({}, optional=FIELDS), max_size=15))
def test_whatever_comes_in_the_answer_is_a_verdict_and_the_wave_is_finite(spoilt):
    inbox = receiver(max_wave=100.0)
    packets = stream(len(spoilt))
    for n, (good, change) in enumerate(zip(packets, spoilt, strict=True)):
        now_ns = n * PERIOD_NS
        assert inbox.push(dataclasses.replace(good, **change), now_ns) in Receipt
        newest = inbox.newest
        wave, position = (0.0, 0.0) if newest is None else (newest.wave, newest.position)
        assert np.size(wave) == 1 and finite(wave) and abs(wave) <= 100.0
        assert finite(position)
        assert all(isinstance(number, int) for number in inbox.echo(now_ns))
        assert inbox.accepted_ns <= now_ns
    assert sum(inbox.counts.values()) == len(spoilt)


@given(data=st.data())
def test_any_order_and_any_copies_end_with_the_newest(data):
    packets = stream(data.draw(st.integers(1, 30)))
    chosen = data.draw(st.lists(st.sampled_from(packets), max_size=60))
    order = data.draw(st.permutations([*chosen, packets[-1]]))
    inbox = receiver()
    verdicts = [inbox.push(packet, 0) for packet in order]
    assert inbox.newest is packets[-1]
    assert inbox.newest.wave == float(len(packets))
    accepted = [p.seq for p, verdict in zip(order, verdicts, strict=True) if verdict in ACCEPTING]
    assert accepted == sorted(set(accepted))


@given(gaps=st.lists(st.integers(1, 5000), min_size=1, max_size=20))
def test_loss_of_any_length_is_counted_and_the_stream_goes_on(gaps):
    inbox, packer = receiver(), Packer(1, period=PERIOD_S)
    for seq in np.cumsum([1, *gaps]).tolist():
        packer.seq = seq - 1
        packet = packer.pack(float(seq), 0.0, seq * PERIOD_NS)
        assert inbox.push(packet, seq * PERIOD_NS) in ACCEPTING
        assert inbox.newest.wave == float(seq)
    assert inbox.lost == sum(gaps) - len(gaps)


def test_after_the_last_number_they_begin_anew():
    inbox = receiver()
    packer = Packer(1, period=PERIOD_S)
    packer.seq = LAST_NUMBER - 3
    packets = [packer.pack(float(n), 0.0, n * PERIOD_NS) for n in range(6)]
    assert [packet.seq for packet in packets[2:4]] == [LAST_NUMBER, 1]
    for packet in (packets[0], *packets[2:]):
        assert inbox.push(packet, 0) in (Receipt.NEW_EPOCH, Receipt.ACCEPTED)
    assert inbox.lost == 1
    assert inbox.push(packets[1], 1) is Receipt.REORDERED
    assert inbox.lost == 0
    assert {inbox.push(packet, 10**9) for packet in packets} == {Receipt.DUPLICATE}
    assert inbox.newest.wave == 5.0
