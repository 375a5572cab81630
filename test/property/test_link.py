# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The link under any settings: conservation, order, and luck that settings do not change."""

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pmwvc_core.network.in_flight import FateKind
from pmwvc_core.network.link import Link
from pmwvc_core.params import LinkParams

FOREVER = 10**15
shares = st.floats(0.0, 1.0)
settings = st.builds(
    LinkParams,
    delay_s=st.floats(0.0, 0.5),
    jitter=st.sampled_from(["none", "uniform", "normal"]),
    jitter_s=st.floats(0.0, 0.5),
    loss=shares,
    duplicate=shares,
    rate_limit_bps=st.one_of(st.just(0.0), st.floats(1e4, 1e8)),
    queue_packets=st.integers(1, 20),
    keep_order=st.booleans(),
)
seeds = st.integers(0, 2**32)
gaps_ns = st.lists(st.integers(0, 50_000_000), min_size=1, max_size=60)


def drive(link, gaps, *, changes=None):
    """Send a packet after each gap; take out what is due; return fates and arrivals."""
    now_ns, fates, out = 0, [], []
    for n, gap in enumerate(gaps):
        now_ns += gap
        if changes and n in changes:
            link.configure(changes[n])
        out += [(now_ns, *arrival) for arrival in link.arrivals(now_ns)]
        fates += link.send(n + 1, now_ns)
    return fates, out + [(FOREVER, *arrival) for arrival in link.arrivals(FOREVER)]


@given(params=settings, seed=seeds, gaps=gaps_ns)
def test_every_packet_has_one_fate_and_every_delivery_was_promised(params, seed, gaps):
    link = Link(params, seed=seed)
    fates, out = drive(link, gaps)
    originals = [fate for fate in fates if fate.kind is not FateKind.DUPLICATE]
    assert {fate.number for fate in fates} == set(range(1, len(gaps) + 1))
    promised = [f for f in fates if f.kind in (FateKind.DELIVERED, FateKind.DUPLICATE)]
    assert sorted(map(id, promised)) == sorted(id(fate) for _, _, fate in out)
    assert all(payload == fate.number for _, payload, fate in out)
    counters = link.counters
    assert counters.in_count == len(gaps) <= len(originals)
    assert counters.queued == 0
    assert len(fates) == counters.out_count + counters.lost + counters.dropped


@given(params=settings, seed=seeds, gaps=gaps_ns)
def test_packets_come_out_when_due_and_never_before_they_went_in(params, seed, gaps):
    _, out = drive(Link(params, seed=seed), gaps)
    dues = [fate.time_due_ns for _, _, fate in out]
    assert all(fate.time_in_ns <= fate.time_due_ns <= now for now, _, fate in out)
    assert dues == sorted(dues)


@given(params=st.lists(settings, min_size=2, max_size=4), seed=seeds, gaps=gaps_ns)
def test_the_same_seed_gives_the_same_fates_also_through_changes(params, seed, gaps):
    changes = {5 * n: p for n, p in enumerate(params)}
    runs = [drive(Link(params[0], seed=seed), gaps, changes=changes) for _ in range(2)]
    assert runs[0] == runs[1]


@given(params=st.lists(settings, min_size=2, max_size=4), seed=seeds, gaps=gaps_ns)
def test_with_order_kept_nothing_overtakes_even_through_changes(params, seed, gaps):
    kept = [LinkParams(**{**vars(p), "keep_order": True}) for p in params]
    link = Link(kept[0], seed=seed)
    _, out = drive(link, gaps, changes={5 * n: p for n, p in enumerate(kept)})
    numbers = [payload for _, payload, _ in out]
    assert numbers == sorted(numbers)


@given(
    before=st.lists(settings, min_size=1, max_size=3),
    after=settings,
    seed=seeds,
    gaps=st.lists(st.integers(0, 50_000_000), min_size=12, max_size=30),
)
def test_the_luck_of_a_packet_does_not_depend_on_the_settings_before_it(before, after, seed, gaps):
    # Two links with one seed and different pasts, then the same settings from packet 10 on.
    after = LinkParams(**{**vars(after), "keep_order": False, "rate_limit_bps": 0.0})
    found = []
    for first in (before[0], before[-1]):
        fates, _ = drive(Link(first, seed=seed), gaps, changes={10: after})
        found.append([fate for fate in fates if fate.number > 10])
    assert found[0] == found[1]


@pytest.mark.parametrize("keep_order", [True, False])
@given(rate=st.floats(1e4, 1e7), seed=seeds, gaps=gaps_ns)
def test_the_line_never_carries_more_than_its_rate(keep_order, rate, seed, gaps):
    params = LinkParams(rate_limit_bps=rate, queue_packets=1000, keep_order=keep_order)
    fates, _ = drive(Link(params, seed=seed), gaps)
    dues = [fate.time_due_ns for fate in fates]
    time_of_one = round(8e9 * 140 / rate)
    steps = [later - earlier for earlier, later in itertools.pairwise(dues)]
    assert all(step >= time_of_one for step in steps)
