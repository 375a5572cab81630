# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Energy of the channel: what may come out of rate drop and hold, for any signal.

Every statement has a control beside it: a scheme that looks alike and breaks the bound.
"""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.filter_runs import Held, Stage
from support.strategies import TICK_S, amplitudes, poles_rad_s, rate_drops, signals

from pmwvc_core.params import FilterParams
from pmwvc_core.wave.aliasing import worst_case_gain

FULL = 8


def energy_j(wave, time_s):
    return 0.5 * time_s * float(np.dot(wave, wave))


def balances(params, u, rate_drop, frames=None):
    """Return energy received so far and balance at each frame end [J]; ``frames`` are the numbers
    of ticks of each frame, where they are not all M.
    """
    stage = Stage(params, rate_drop=rate_drop, axes=np.size(u[0]))
    received, sent, found, rest = 0.0, 0.0, [], iter(u)
    for length in frames or [rate_drop] * (len(u) // rate_drop):
        ticks = [value for _, value in zip(range(length), rest, strict=False)]
        if len(ticks) < length:
            break
        for value in ticks:
            received += energy_j(value, TICK_S)
            stage.step(value)
        sent += energy_j(stage.sample(), rate_drop * TICK_S)
        found.append((received, received - sent))
    return np.array(found).reshape(-1, 2).T


@pytest.mark.parametrize("dof", [None, 3])
@given(
    st.data(),
    rate_drops,
    st.one_of(st.none(), st.lists(st.integers(1, 30), min_size=1, max_size=20)),
)
def test_integrate_and_dump_never_sends_more_than_it_got(dof, data, rate_drop, frames):
    """Also where frames lose ticks or get more."""
    u = data.draw(signals(dof=dof))
    u = u if dof else u.tolist()
    energy, balance = balances(FilterParams(kind="integrate_and_dump"), u, rate_drop, frames)
    assert (balance >= -1e-12 * energy).all()


@pytest.mark.parametrize("rate_drop", [2, 20])
def test_plain_down_sampler_can_emit_energy(rate_drop):
    spike = [*[0.0] * (rate_drop - 1), 1.0]
    _, balance = balances(FilterParams(kind="none"), spike, rate_drop)
    assert balance[0] == pytest.approx(-(rate_drop - 1) * TICK_S / 2)


filters = st.one_of(
    poles_rad_s.map(lambda pole: FilterParams(kind="first_order", pole_rad_s=pole)),
    st.sampled_from(["pass", "stop"]).map(
        lambda meet: FilterParams(kind="butterworth", stop_hz=50.0, meet=meet)
    ),
)


@given(u=signals(), rate_drop=rate_drops, params=filters)
def test_a_filter_sends_at_most_its_worst_case(u, rate_drop, params):
    """So one divided by the root of its gain is passive."""
    gain = worst_case_gain(params, tick_s=TICK_S, rate_drop=rate_drop)
    energy, balance = balances(params, u.tolist(), rate_drop)
    assert (energy - balance <= gain * energy * (1.0 + 1e-9)).all()


@pytest.mark.parametrize("pole, rate_drop", [(50.0, 8), (51.293, 20)])
def test_undivided_it_emits_energy_and_the_worst_case_is_not_an_estimate(pole, rate_drop):
    """A wave that grows as the filter forgets: the singular vector of rest, cut off far away."""
    params = FilterParams(kind="first_order", pole_rad_s=pole)
    ticks = np.arange(40_000)
    slow = np.sin(np.pi * (ticks + 0.5) / len(ticks))
    p = math.exp(-pole * TICK_S)
    h = (1 - p) * p ** np.arange(400)
    shaped = np.zeros(len(ticks))
    for n in range(rate_drop - 1, len(ticks), rate_drop):  # the adjoint of filter and drop
        reach = min(n + 1, len(h))
        shaped[n - reach + 1 : n + 1] += slow[n] * h[:reach][::-1]
    energy, balance = balances(params, shaped.tolist(), rate_drop)
    ratio = (energy[-1] - balance[-1]) / energy[-1]
    gain = worst_case_gain(params, tick_s=TICK_S, rate_drop=rate_drop)
    assert 1.0 < ratio <= gain
    assert ratio == pytest.approx(gain, rel=1e-4)


def expand(held, packets, lengths):
    """Return energy received with the packets and emitted at the ticks [J], and the least that was
    left.
    """
    received = emitted = 0.0
    least = math.inf
    for v, length in zip(packets, lengths, strict=True):
        received += energy_j(v, FULL * TICK_S)
        held.load(v)
        for _ in range(length):
            emitted += energy_j(held.step(), TICK_S)
        least = min(least, received - emitted)
    return received, emitted, least


@pytest.mark.parametrize("kind", ["zoh", "foh"])
@given(train=st.lists(st.tuples(amplitudes, st.integers(0, FULL)), min_size=1, max_size=40))
def test_a_hold_emits_no_more_than_it_got_while_no_packet_is_late(kind, train):
    """Over whole frames a zero-order hold is lossless; a late packet makes either give more."""
    packets, lengths = zip(*train, strict=True)
    received, _, least = expand(Held(kind, ticks=FULL), packets, lengths)
    assert least >= -1e-12 * received
    if kind == "zoh":
        received, emitted, _ = expand(Held(kind, ticks=FULL), packets, [FULL] * len(packets))
        assert emitted == pytest.approx(received, rel=1e-12)
    if packets[0]:
        _, _, least = expand(Held(kind, ticks=FULL), packets[:1] * 2, [FULL, 2 * FULL])
        assert least < 0.0


@pytest.mark.parametrize("ticks", [1, 2, 20])
def test_a_first_order_hold_stores_a_quarter_of_what_its_last_ticks_would_carry(ticks):
    """For any value c at the load and any packet v: M v^2 + s c^2 >= emitted + s (value after)^2,
    s = (M-1)/2, as quadratic form in (c, v); for whole frames no smaller s would do.
    """
    s = 0.5 * (ticks - 1)
    for length in range(ticks + 1):
        held = Held("foh", ticks=ticks, axes=2)
        held.load(np.array([1.0, 0.0]))
        for _ in range(ticks):
            after = held.step()
        held.load(np.array([0.0, 1.0]))
        form = np.diag([s, float(ticks)])
        for _ in range(length):
            after = held.step()
            form -= np.outer(after, after)
        form -= s * np.outer(after, after)
        assert np.linalg.eigvalsh(form)[0] >= -1e-12 * ticks
    assert np.linalg.eigvalsh(form)[0] == pytest.approx(0.0, abs=1e-12 * ticks)
