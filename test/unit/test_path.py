# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One-way delay, jitter, offset and drift of a path, against simulated clocks with known truth.

What cannot be known is tested too: two different truths that no packet tells apart.
"""

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.packer import Packer

from pmwvc_core.transport.path import Path, Shortest, clock_line

MS = 1_000_000
FRAME_NS = 8 * MS


@dataclass(frozen=True)
class Truth:
    """A path and two clocks: theta = the other end's clock less this one's."""

    theta_ns: int = 3_600 * 10**9
    drift: float = 0.0
    out_ns: int = 16 * MS
    into_ns: int = 16 * MS
    jitter_ns: float = 0.0
    loss: float = 0.0
    seconds: int = 20
    step_ns: int = 0  # longer out, and shorter in,
    step_begins: float = 0.5  # from this part of the time on

    def theta(self, true_ns):
        return self.theta_ns + round(self.drift * true_ns)


def run(truth, seed=1, path=None):
    """Converse both ways; this end's clock is the true time. Return its path."""
    random = np.random.default_rng(seed)
    path = path or Path()
    count = truth.seconds * 10**9 // FRAME_NS
    here, there = Packer(1, period=0.008), Packer(2, period=0.008)
    late = random.exponential(1.0, (2, count)) * truth.jitter_ns
    lost = random.random((2, count)) < truth.loss
    out, into = [], []  # (arrival, packet), in true time
    newest_there = None
    for k in range(count):
        now = k * FRAME_NS
        packet = here.pack(0.0, 0.0, now)
        step = truth.step_ns if k >= truth.step_begins * count else 0
        if not lost[0, k]:
            out.append((now + truth.out_ns + step + round(late[0, k]), packet))
        reply = now + 3 * MS
        arrived = [(at, p) for at, p in out if at <= reply]
        out = [(at, p) for at, p in out if at > reply]
        newest = max(arrived, key=lambda pair: pair[1].seq, default=newest_there)
        if newest_there is None or (newest and newest[1].seq > newest_there[1].seq):
            newest_there = newest
        echo = (0, 0, 0)
        if newest_there:
            at, p = newest_there
            echo = (p.seq, p.sent_ns, reply + truth.theta(reply) - at - truth.theta(at))
        back = there.pack(0.0, 0.0, reply + truth.theta(reply), echo=echo)
        if not lost[1, k]:
            into.append((reply + truth.into_ns - step + round(late[1, k]), back))
    newest_seq = 0
    for came, packet in sorted(into, key=lambda pair: pair[0]):
        if packet.seq > newest_seq:  # what a receiver accepts
            newest_seq = packet.seq
            path.add(packet, came)
    return path


def test_nothing_is_claimed_before_a_second_of_both_directions():
    assert Path().estimate() is None
    assert run(Truth(out_ns=0, into_ns=0, seconds=1)).estimate() is None
    path = Path()
    packer = Packer(2, period=0.008)
    for k in range(1000):
        path.add(packer.pack(0.0, 0.0, k * FRAME_NS), k * FRAME_NS)  # no echo: one direction only
    assert path.estimate() is None


@pytest.mark.parametrize(("out_ms", "into_ms"), [(16, 16), (5, 40), (40, 5)])
def test_on_one_clock_the_delay_of_each_direction_is_exact(out_ms, into_ms):
    found = run(Truth(theta_ns=0, out_ns=out_ms * MS, into_ns=into_ms * MS)).estimate()
    assert found.one_clock and found.open_s == 0.0 and found.offset_s == 0.0
    assert found.out.least_s == pytest.approx(out_ms * 1e-3)
    assert found.into.least_s == pytest.approx(into_ms * 1e-3)


def test_a_constant_asymmetry_cannot_be_told_from_an_offset_and_is_not():
    """Two truths, packet for packet the same: the estimate is one, and its bound covers both."""
    first = Truth(theta_ns=10**12, out_ns=40 * MS, into_ns=6 * MS)
    other = Truth(theta_ns=10**12 + 34 * MS, out_ns=6 * MS, into_ns=40 * MS)
    found, same = run(first).estimate(), run(other).estimate()
    assert tuple(found.out) == pytest.approx(tuple(same.out))
    assert tuple(found.into) == pytest.approx(tuple(same.into))
    assert (found.offset_s, found.open_s) == pytest.approx((same.offset_s, same.open_s))
    assert found.round_trip_s == pytest.approx(0.046)
    assert found.open_s == pytest.approx(0.023, abs=1e-4)
    for truth in (first, other):
        assert abs(found.offset_s - truth.theta_ns * 1e-9) <= found.open_s + 1e-6
        assert abs(found.out.least_s - truth.out_ns * 1e-9) <= found.open_s + 1e-6
        assert abs(found.into.least_s - truth.into_ns * 1e-9) <= found.open_s + 1e-6


truths = st.builds(
    Truth,
    theta_ns=st.integers(-(10**17), 10**17).filter(lambda theta: abs(theta) > 10**10),
    drift=st.floats(-400e-6, 400e-6),
    out_ns=st.integers(0, 100 * MS),
    into_ns=st.integers(0, 100 * MS),
    jitter_ns=st.sampled_from([0.0, 0.3 * MS, 3.0 * MS]),
    loss=st.sampled_from([0.0, 0.2]),
)


@settings(max_examples=15)
@given(truth=truths, seed=st.integers(0, 99))
def test_truth_is_within_what_is_given_whatever_clocks_and_path_are(truth, seed):
    path = run(truth, seed)
    found = path.estimate()
    least = (truth.out_ns + truth.into_ns) * 1e-9
    reading = 2e-6 + abs(truth.drift) * least  # clocks drift while a packet travels
    assert not found.one_clock
    at_ns = path.windows[-1].start_ns + 500 * MS
    assert abs(found.offset_s - truth.theta(at_ns) * 1e-9) <= found.open_s + reading
    assert abs(found.drift_ppm - truth.drift * 1e6) <= found.drift_open_ppm + 1e-6
    drifted = truth.seconds * found.drift_open_ppm * 1e-6
    assert least - reading - drifted <= found.round_trip_s
    assert found.round_trip_s <= least + truth.jitter_ns * 1e-9 + drifted + reading
    for seen, delay in ((found.out, truth.out_ns), (found.into, truth.into_ns)):
        assert abs(seen.least_s - delay * 1e-9) <= found.open_s + truth.jitter_ns * 1e-9 + reading
        drifts = reading + abs(truth.drift) * 0.5  # of a window, of which the middle is taken
        assert seen.least_s - drifts <= seen.mean_s <= seen.most_s + drifts


def test_drift_is_followed_and_without_it_the_offset_would_be_wrong():
    truth = Truth(drift=100e-6, seconds=60, jitter_ns=0.2 * MS)
    path = run(truth)
    found = path.estimate()
    assert found.drift_ppm == pytest.approx(100.0, abs=2.0)
    assert found.drift_open_ppm < 10.0
    at_ns = path.windows[-1].start_ns + 500 * MS
    assert abs(found.offset_s - truth.theta(at_ns) * 1e-9) < 0.5e-3  # 6 ms of drift in a minute
    windows = path.windows  # the control: one theta for all windows
    standing = min(w.out.least.passage_ns for w in windows)
    standing -= min(w.into.least.passage_ns for w in windows)
    assert abs(standing / 2 - truth.theta(at_ns)) > 2 * MS


def test_jitter_is_that_of_its_own_direction_whatever_the_clocks():
    """|X - Y| of two exponential delays has the mean of one of them."""
    both = run(Truth(jitter_ns=1.5 * MS, drift=50e-6))
    found = both.estimate()
    for seen in (found.out, found.into):
        assert 0.5e-3 < seen.jitter_s < 3.5e-3
        assert seen.mean_s - seen.least_s == pytest.approx(1.5e-3, rel=0.5)
    none = run(Truth(drift=50e-6)).estimate()
    assert none.out.jitter_s < 1e-6 and none.into.jitter_s < 1e-6


@pytest.mark.parametrize("begins", [0.5, 0.9])
def test_a_route_that_changes_is_no_drift(begins):
    """10 ms longer out and 10 ms shorter in: no drift does that, and none is claimed."""
    path = run(Truth(step_ns=10 * MS, step_begins=begins, seconds=30))
    found = path.estimate()
    assert abs(found.drift_ppm) <= found.drift_open_ppm
    assert abs(found.offset_s - 3600.0) <= found.open_s
    if begins == 0.9:  # three windows of thirty fit no line with the others
        path.windows = [
            w for n, w in enumerate(path.windows) if n not in (26, 27)
        ]  # of the change
        windows = path.windows
        every = [w.out.least for w in windows], [w.into.least for w in windows]
        assert clock_line(*every) is None
        assert path.estimate() is not None  # from what came since


@pytest.mark.parametrize("count", [3, 20])
@pytest.mark.parametrize("kind", ["half normal", "exponential", "lognormal", "uniform"])
def test_a_drift_is_within_its_bound_whatever_the_noise_of_the_least_passages_is(kind, count):
    random = np.random.default_rng(0)
    draw = {
        "half normal": lambda: np.abs(random.normal(0.0, 50e3, count)),
        "exponential": lambda: random.exponential(50e3, count),
        "lognormal": lambda: 20e3 * random.lognormal(0.0, 1.2, count),
        "uniform": lambda: random.uniform(0.0, 100e3, count),
    }[kind]
    outside = 0
    for _ in range(50):
        rate, ends = random.uniform(-1e-4, 1e-4), []
        for sign in (1, -1):
            times = np.arange(count) * 1e9 + random.uniform(0.0, 9e8, count)
            passages = 8e6 + draw() + sign * (1e13 + rate * times)
            ends.append([Shortest(int(t), int(p)) for t, p in zip(times, passages, strict=True)])
        line = clock_line(*ends)
        outside += line is not None and abs(line.rate - rate) > line.rate_open
    assert outside == 0


def test_of_times_beyond_any_clock_nothing_is_claimed():
    path = Path()
    packer = Packer(2, period=0.008)
    for k in range(300):
        sent = (-(2**63), 2**63 - 1, k)[k % 3]
        packet = packer.pack(0.0, 0.0, sent, echo=(k + 1, 2**63 - 1 - k, -(2**63)))
        path.add(packet, k * FRAME_NS)
        assert path.estimate() is None
    assert len(path.windows) == 2  # their sums of both passages are those of a round trip
    path.restart()
    assert run(Truth(), path=path).estimate() == run(Truth()).estimate()
