# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The mode netem: what Linux does, faults included; and the command of Linux for a link."""

import json

import numpy as np
import pytest
from support.command_line import call

from pmwvc_core.errors import ParameterError
from pmwvc_core.network.in_flight import FateKind
from pmwvc_core.network.link import Link
from pmwvc_core.network.netem_mode import SCALE, linux_table, table_of
from pmwvc_core.network.presets import PRESETS
from pmwvc_core.network.tc import not_in_tc, table_text, tc_line
from pmwvc_core.params import LinkParams

MS = 1_000_000


def link(seed=1, **settings):
    return Link(LinkParams(mode="netem", keep_order=False, **settings), seed=seed)


def delays_ns(channel, count, *, every_ns=MS):
    fates = [channel.send(n, n * every_ns)[0] for n in range(count)]
    return np.array([fate.time_due_ns - fate.time_in_ns for fate in fates if fate.time_due_ns])


def test_a_packet_that_is_lost_and_copied_is_one_packet():
    fates = link(loss=1.0, duplicate=1.0).send("a", 0)
    # the loss takes away the copy, not the packet
    assert [fate.kind for fate in fates] == [FateKind.DELIVERED]


def test_a_copy_is_judged_again():
    channel = link(seed=4, loss=0.3, duplicate=1.0)
    sent = [channel.send(n, n * MS) for n in range(3000)]
    pairs = [each for each in sent if len(each) == 2]
    assert len(pairs) == pytest.approx(2100, abs=3 * 25)
    lost = sum(copy.kind is FateKind.LOST for _, copy in pairs)
    assert lost == pytest.approx(0.3 * len(pairs), abs=3 * 21)


def test_a_table_ends_at_four_deviations_and_pareto_is_too_narrow():
    for name in ("normal", "pareto", "paretonormal"):
        table = np.array(linux_table(name)) / SCALE
        assert len(table) == 4096 and (np.diff(table) >= 0.0).all()
        assert np.abs(table).max() <= 4.0
    assert np.array(linux_table("pareto")).std() / SCALE == pytest.approx(0.82, abs=0.01)
    assert np.array(linux_table("normal")).std() / SCALE == pytest.approx(1.0, abs=2e-3)


def test_correlated_jitter_has_no_correlation_and_correlated_delay_still_its_spread():
    settings = {"delay_s": 0.1, "jitter": "normal", "jitter_s": 0.01, "jitter_correlation": 0.75}
    delays = delays_ns(link(**settings), 8000) * 1e-6
    assert delays.std() == pytest.approx(10.0, rel=0.03)
    assert abs(np.corrcoef(delays[1:], delays[:-1])[0, 1]) < 4.0 / np.sqrt(8000)


def test_every_gapth_packet_is_sent_at_once():
    delays = delays_ns(link(delay_s=0.1, reorder=1.0, reorder_gap=5), 20)
    assert np.flatnonzero(delays == 0).tolist() == [4, 9, 14, 19]


def test_the_rate_acts_after_the_delay():
    # 1000 bytes at 1 Mbit/s take 8 ms; the second waits for the first, and its delay meanwhile
    channel = link(delay_s=0.01, rate_limit_bps=1e6)
    dues = [channel.send(n, 0, size_bytes=1000)[0].time_due_ns // MS for n in range(3)]
    assert dues == [18, 26, 34]
    # the link itself sends first and delays then
    other = Link(LinkParams(delay_s=0.01, rate_limit_bps=1e6), seed=1)
    assert [other.send(n, 0, size_bytes=1000)[0].time_due_ns // MS for n in range(3)] == dues


def test_all_that_is_inside_counts_for_the_limit():
    channel = link(delay_s=2.0)
    kinds = [channel.send(n, n * MS)[0].kind for n in range(1200)]
    assert kinds.count(FateKind.DELIVERED) == 1000 and kinds[999] is FateKind.DELIVERED
    assert kinds[1000] is FateKind.DROPPED_QUEUE


def test_a_slot_is_drawn_when_the_queue_meets_a_gate_that_is_past():
    channel = link(slot_min_s=0.01, slot_max_s=0.01, slot_packets=2)
    out = []
    for n in range(6):
        channel.send(n, n * MS)
        out += [(payload, fate.time_due_ns // MS) for payload, fate in channel.arrivals(n * MS)]
    out += [(payload, fate.time_due_ns // MS) for payload, fate in channel.arrivals(10**9)]
    # the first meets a gate of the past: 10 ms on; then two in every slot
    assert out == [(0, 10), (1, 10), (2, 20), (3, 20), (4, 30), (5, 30)]
    assert channel.next_due_ns is None


@pytest.mark.parametrize(
    "settings, text",
    [
        ({"handover_s": 15.0}, "handover_s = 15.0: must be 0.0 with mode = netem"),
        ({"schedule": "1 outage"}, "schedule = '1 outage': must be ''"),
        ({"loss": 0.1, "ge_p": 0.1}, "loss = 0.1 and ge_p = 0.1: must be one model"),
    ],
)
def test_what_linux_does_not_have_is_refused(settings, text):
    with pytest.raises(ParameterError, match=text):
        link(**settings)


def test_order_cannot_be_kept_against_jitter():
    with pytest.raises(ParameterError, match="keep_order = True: must be false"):
        Link(LinkParams(mode="netem", delay_s=0.1, jitter_s=0.01), seed=1)


def test_the_command_states_every_setting():
    params = LinkParams(
        delay_s=0.02,
        jitter="normal",
        jitter_s=0.005,
        jitter_correlation=0.25,
        ge_p=0.01,
        ge_r=0.5,
        duplicate=0.01,
        corrupt=0.001,
        reorder=0.25,
        reorder_gap=5,
        rate_limit_bps=1e6,
        rate_overhead_bytes=42,
        slot_min_s=0.001,
        slot_max_s=0.002,
        keep_order=False,
        mode="netem",
    )
    assert tc_line(params, device="eth0", seed=7) == (
        "tc qdisc replace dev eth0 root netem limit 100 delay 20ms 5ms 25% distribution normal "
        "loss gemodel 1% 50% 100% 0% duplicate 1% corrupt 0.1% reorder 25% gap 5 "
        "rate 1000000bit 42 slot 1ms 2ms seed 7"
    )
    assert not_in_tc(params) == []
    assert tc_line(LinkParams(delay_s=0.016)).endswith("netem limit 100000 delay 16ms")


def test_what_the_command_leaves_out_is_said():
    said = not_in_tc(PRESETS["leo"].up)
    assert said == [
        "a hand-over every 15 s (+-10 ms; about 0.024 of the packets lost)",
    ]
    exact = LinkParams(loss=0.1, loss_correlation=0.5, jitter_s=0.01)
    assert not_in_tc(exact) == [
        "the order of packets, which jitter changes there",
        "correlation that keeps probabilities and distributions",
    ]


def test_links_are_printed_with_their_command_and_their_tables_written(tmp_path):
    words = ["links", "carry_16ms", "--users", "1", "--set", "link.preset=continental"]
    answer = call(*words, "--out", tmp_path, "--json", cwd=tmp_path)
    (up, down) = json.loads(answer.stdout)["links"]
    assert up["name"] == "user1/up" and up["mean_delay_s"] == pytest.approx(0.022)
    assert f"distribution {up['table']} loss gemodel" in up["tc"] and down["tc"] == up["tc"]
    params = PRESETS["continental"].up
    text = (tmp_path / f"{up['table']}.dist").read_text()
    assert text == table_text(params)
    numbers = np.array(text.split("\n", 1)[1].split(), dtype=int)
    assert tuple(numbers) == table_of(params)
    # delay + deviation * number/8192 are the quantiles of the link
    assert 0.020 - 1e-4 < 0.022 + 0.00141421 * numbers[0] / SCALE < 0.0201
