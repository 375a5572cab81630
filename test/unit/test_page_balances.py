# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy balances that a page keeps, from counters that masters and server report."""

import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pmwvc_view.feed.accounts import MasterSums, PageBalance, PageBalances, ServerSums

sums = st.lists(st.floats(0.0, 1.0), min_size=4, max_size=40).map(
    lambda parts: list(itertools.accumulate(parts))
)


@given(sums, st.integers(0, 3), st.integers(-6, 6))
def test_passive_channel_is_never_below_zero_whoever_reports_late(sent, late, behind):
    """What arrives at a step was sent ``late`` blocks before; the blocks of the master are told
    ``behind`` frames after the steps, or before them.
    """
    accounts = PageBalances()
    calls = []
    for number, energy in enumerate(sent):
        arrived = sent[number - 1 - late] if number > late else 0.0
        block_sums = MasterSums(8 * number + 7, 1, energy, 0.0, energy)
        step_sums = ServerSums(8 * number + 2, 1, arrived, 0.0)
        calls.append((number + behind + 0.5, lambda told=block_sums: accounts.block(told)))
        calls.append((number, lambda told=step_sums: accounts.step(told)))
    for _, call in sorted(calls, key=lambda each: each[0]):
        call()
    assert accounts.up.least_j == accounts.hand.least_j == 0.0
    assert accounts.known_ns == 8 * (len(sent) - 2) + 7  # each block with a later step, balanced


@pytest.mark.parametrize(("moved_j", "violated"), [(0.0, True), (100.0, False)])
def test_a_deficit_is_judged_by_what_had_moved_at_its_time(moved_j, violated):
    account = PageBalance()
    account.at(1, moved_j, moved_j + 2e-6, judged=True)
    assert (account.margin_j < 0.0) is violated
    account.at(2, 1e3, 1e3, judged=True)
    assert (account.margin_j < 0.0) is violated
    assert account.least_ns == int(violated)


@pytest.mark.parametrize(("work_j", "judged"), [(0.4, True), (0.2, False)])
def test_counters_without_waves_are_judged_where_the_hand_has_given_what_the_server_has(
    work_j, judged
):
    """The wave of a packet of the strict channel is not the one that it was paid for."""
    accounts = PageBalances()
    accounts.step(ServerSums(2, 1, 0.5, 0.2))
    accounts.block(MasterSums(7, 1, math.nan, math.nan, work_j))
    accounts.step(ServerSums(10, 1, 0.5, 0.2))
    assert accounts.known_ns == 7
    assert accounts.judged is judged


def test_counter_that_begins_anew_is_counted_on_and_not_judged():
    accounts = PageBalances()
    for number in range(20):
        epoch = 1 if number < 10 else 2
        since = number if epoch == 1 else number - 10
        accounts.step(ServerSums(8 * number + 2, 1, 1e-3 * number, 0.0))
        accounts.block(MasterSums(8 * number + 7, epoch, 1e-3 * since, 0.0, 0.0))
    assert not accounts.judged
    assert accounts.up.least_j == 0.0
