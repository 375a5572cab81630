# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The record of fates."""

import numpy as np

from pmwvc_core.network.in_flight import Cause, FateKind, FateLog
from pmwvc_core.network.link import Link
from pmwvc_core.params import LinkParams


def test_records_come_out_as_columns_in_the_order_they_became_final():
    link = Link(LinkParams(delay_s=0.001), seed=1)
    log = FateLog()
    link.send("a", 100, size_bytes=126)
    link.send("b", 200)
    for _, fate in link.arrivals(10**9):
        log.add(fate, time_out_ns=fate.time_due_ns + 7, epoch=2**63 + 5, seq=fate.number + 10)
    block = log.take()
    assert block["first"] == 1
    assert block["epoch"].tolist() == [2**63 + 5] * 2
    assert block["seq"].tolist() == [11, 12]
    assert block["bytes"].tolist() == [126, 140]
    assert block["time_in_ns"].tolist() == [100, 200]
    assert block["time_due_ns"].tolist() == [1_000_100, 1_000_200]
    assert (block["time_out_ns"] - block["time_due_ns"]).tolist() == [7, 7]
    assert block["fate"].tolist() == [FateKind.DELIVERED] * 2
    assert block["cause"].tolist() == [Cause.NONE] * 2


def test_a_lost_packet_has_no_time_out_and_the_links_own_number():
    log = FateLog()
    (fate,) = Link(LinkParams(loss=1.0), seed=1).send("a", 100)
    log.add(fate)
    block = log.take()
    assert (block["seq"][0], block["time_due_ns"][0], block["time_out_ns"][0]) == (1, 0, 0)
    assert (block["fate"][0], block["cause"][0]) == (FateKind.LOST, Cause.LOSS)


def test_blocks_follow_one_another_without_a_gap():
    log = FateLog()
    link = Link(LinkParams(), seed=1)
    for n in range(5):
        log.add(link.send(n, n)[0])
    first, second = log.take(3), log.take(3)
    assert (first["first"], len(first["seq"])) == (1, 3)
    assert (second["first"], second["seq"].tolist()) == (4, [4, 5])
    assert len(log) == 0


def test_an_empty_block_has_typed_columns():
    block = FateLog().take()
    assert block["first"] == 1 and len(block["time_in_ns"]) == 0
    assert block["epoch"].dtype == np.uint64 and block["fate"].dtype == np.uint8
