# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The command of Linux that comes nearest to a link."""

import json

import numpy as np
import pytest
from support.command_line import call

from pmwvc_core.network.presets import PRESETS
from pmwvc_core.network.tc import SCALE, not_in_tc, table_of, table_text, tc_line
from pmwvc_core.params import LinkParams

MS = 1_000_000


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
    )
    assert tc_line(params, device="eth0", seed=7) == (
        "tc qdisc replace dev eth0 root netem limit 100 delay 20ms 5ms 25% distribution normal "
        "loss gemodel 1% 50% 100% 0% duplicate 1% corrupt 0.1% reorder 25% gap 5 "
        "rate 1000000bit 42 slot 1ms 2ms seed 7"
    )
    assert not_in_tc(params) == [
        "correlation that keeps probabilities and distributions",
        "slots that go on while nothing is sent",
    ]
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
