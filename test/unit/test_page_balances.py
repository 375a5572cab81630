# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy balances that a page keeps, from counters that masters and server report."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pmwvc_view.feed.balances import WAYS, Balances, ServerBalance

sums = st.lists(st.floats(0.0, 1.0), min_size=4, max_size=40).map(
    lambda parts: list(itertools.accumulate(parts))
)


@given(sums, st.integers(0, 3), st.integers(-6, 6))
def test_passive_channel_is_never_below_zero_whoever_reports_late(sent, late, behind):
    """What arrives at a step was sent ``late`` blocks before; the blocks of the master are told
    ``behind`` frames after the steps, or before them.
    """
    blocks = [(8.0 * k + 7.0, 1.0, energy, 0.0, energy) for k, energy in enumerate(sent)]
    arrived = [sent[k - 1 - late] if k > late else 0.0 for k in range(len(sent))]
    steps = [(8.0 * k + 2.0, 1.0, energy, 0.0) for k, energy in enumerate(arrived)]
    balances = Balances()
    for told in range(1 - abs(behind), len(sent) + abs(behind) + 1):
        first, second = blocks[: max(told - behind, 0)], steps[: max(told, 0)]
        if first and second:
            balances.update(np.array(first), np.array(second))
    assert balances.worst["way up"].balance_j == balances.worst["hand to object"].balance_j == 0.0
    table = balances.table.rows
    assert table[-1, 0] == 8 * (len(sent) - 2) + 7  # each block with a later step, balanced
    np.testing.assert_array_equal(table[:, 3], 0.0)


def balance(*rows):
    """Return balances of blocks ``(life, up, down, work)`` and steps ``(life, u_s, v_s)``, by
    turns.
    """
    blocks = [(8.0 * k + 7.0, *block) for k, (block, _) in enumerate(rows)]
    steps = [(8.0 * k + 2.0, *step) for k, (_, step) in enumerate(rows)]
    found = Balances()
    found.update(np.array(blocks), np.array([*steps, (8.0 * len(rows) + 2.0, *rows[-1][1])]))
    return found


@pytest.mark.parametrize(("moved_j", "violated"), [(0.0, True), (100.0, False)])
def test_a_deficit_is_judged_by_what_had_moved_at_its_time(moved_j, violated):
    rows = [(0.0, 0.0), (moved_j, moved_j + 2e-6), (1e3, 1e3)]
    worst = balance(*(((1, up, 0.0, up), (1, u_s, 0.0)) for up, u_s in rows)).worst["way up"]
    assert (worst.margin_j < 0.0) is violated
    assert (worst.time_s == 15.0) is violated


@pytest.mark.parametrize(("work_j", "judged"), [(0.4, True), (0.2, False)])
def test_counters_without_waves_are_judged_where_the_hand_has_given_what_the_server_has(
    work_j, judged
):
    """The wave of a packet of the strict channel is not the one that it was paid for."""
    found = balance(((1, math.nan, math.nan, work_j), (1, 0.5, 0.2)))
    assert found.known and not found.channel_known
    assert found.judged is judged


@pytest.mark.parametrize("of_server", [False, True])
def test_counter_that_begins_anew_is_counted_on_and_not_judged(of_server):
    lives = [((1, k), (1, k)) if k < 10 else ((2, k - 10), (1, k)) for k in range(20)]
    if of_server:
        lives = [(step, block) for block, step in lives]
    rows = [((a, 1e-3 * up, 0.0, 1e-3 * up), (b, 1e-3 * u_s, 0.0)) for (a, up), (b, u_s) in lives]
    found = balance(*rows)
    assert not found.judged
    assert found.worst == dict.fromkeys(WAYS, found.worst["way up"])
    assert found.table.rows[-1, 1] == pytest.approx(9e-3) == found.table.rows[-1, 2]


def test_what_a_server_gives_out_is_the_largest_deficit_of_its_ports_in_its_first_life():
    found, ran_s = ServerBalance(), 0.008 * np.arange(1, 5)
    sums = np.array([[[1.0, 2.0], [0.5, 1.0]], [[1.5, 2.0], [1.5, 2.5]], [[3, 3], [1, 1]]])
    lives = np.zeros((3, 2))
    found.update(ran_s[:2], lives[:2], sums[:2])
    assert found.worst.balance_j == pytest.approx(-0.5) and found.worst.time_s == ran_s[1]
    found.update(ran_s[:3], lives, sums)  # what was seen is not balanced again
    again = np.array([[[0.0, 9.0], [8.0, 9.0]]])  # a counter began anew
    found.update(ran_s[3:], lives[:1] + 1.0, again)
    assert found.worst.balance_j == pytest.approx(-0.5)
