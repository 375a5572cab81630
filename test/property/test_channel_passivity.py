# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Energy of the channel: what may come out of rate drop and hold, for any signal.

Every statement has a control beside it: a scheme that looks alike and breaks the bound.
"""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from support.filter_runs import Held, Stage
from support.strategies import TICK_S, amplitudes, poles_rad_s, rate_drops, signals

from pmwvc_core.params import FilterParams
from pmwvc_core.wave.aliasing import worst_case_gain


def energy_j(wave, time_s):
    return 0.5 * time_s * float(np.dot(wave, wave))


def balances(params, u, rate_drop, *, frames=None):
    """Return energy received so far and balance at each frame end [J].

    ``frames`` are the numbers of ticks of each frame, where they are not all M.
    """
    stage = Stage(params, rate_drop=rate_drop, axes=np.size(u[0]))
    received = sent = 0.0
    lengths = iter(frames if frames is not None else [rate_drop] * (len(u) // rate_drop))
    left = next(lengths, 0)
    found = []
    for value in u:
        if left == 0:
            break
        received += energy_j(value, TICK_S)
        stage.step(value)
        left -= 1
        if left == 0:
            sent += energy_j(stage.sample(), rate_drop * TICK_S)
            found.append((received, received - sent))
            left = next(lengths, 0)
    energy, balance = np.array(found).reshape(-1, 2).T
    return energy, balance


INTEGRATE = FilterParams(kind="integrate_and_dump")
PLAIN = FilterParams(kind="none")


@given(u=signals(), rate_drop=rate_drops)
def test_integrate_and_dump_never_sends_more_than_it_got(u, rate_drop):
    energy, balance = balances(INTEGRATE, u.tolist(), rate_drop)
    assert (balance >= -1e-12 * energy).all()


@given(u=signals(dof=3), rate_drop=rate_drops)
def test_integrate_and_dump_is_passive_on_several_axes(u, rate_drop):
    energy, balance = balances(INTEGRATE, u, rate_drop)
    assert (balance >= -1e-12 * energy).all()


@given(u=signals(), rate_drop=rate_drops, frames=st.lists(st.integers(1, 30), max_size=20))
def test_integrate_and_dump_is_passive_when_frames_lose_ticks_or_get_more(u, rate_drop, frames):
    energy, balance = balances(INTEGRATE, u.tolist(), rate_drop, frames=frames)
    assert (balance >= -1e-12 * energy).all()


@pytest.mark.parametrize("rate_drop", [2, 8, 20])
def test_plain_down_sampler_can_emit_energy(rate_drop):
    spike = [0.0] * rate_drop
    spike[-1] = 1.0
    _, balance = balances(PLAIN, spike, rate_drop)
    assert balance[0] == pytest.approx(-(rate_drop - 1) * TICK_S / 2)


@given(u=signals(), rate_drop=rate_drops, pole=poles_rad_s)
def test_a_first_order_filter_sends_at_most_its_worst_case(u, rate_drop, pole):
    params = FilterParams(kind="first_order", pole_rad_s=pole)
    gain = worst_case_gain(params, tick_s=TICK_S, rate_drop=rate_drop)
    energy, balance = balances(params, u.tolist(), rate_drop)
    assert (energy - balance <= gain * energy * (1.0 + 1e-9)).all()


@pytest.mark.parametrize("meet", ["pass", "stop"])
@given(u=signals(), rate_drop=rate_drops)
def test_a_butterworth_filter_sends_at_most_its_worst_case(u, rate_drop, meet):
    params = FilterParams(kind="butterworth", stop_hz=50.0, meet=meet)
    gain = worst_case_gain(params, tick_s=TICK_S, rate_drop=rate_drop)
    energy, balance = balances(params, u.tolist(), rate_drop)
    assert (energy - balance <= gain * energy * (1.0 + 1e-9)).all()


@given(u=signals(shortest=8), pole=poles_rad_s)
def test_a_first_order_filter_divided_by_the_root_of_its_gain_is_passive(u, pole):
    params = FilterParams(kind="first_order", pole_rad_s=pole)
    scale = 1.0 / math.sqrt(worst_case_gain(params, tick_s=TICK_S, rate_drop=8))
    energy, balance = balances(params, u.tolist(), 8)
    assert (energy - scale**2 * (energy - balance) >= -1e-9 * energy).all()


@pytest.mark.parametrize("pole, rate_drop", [(50.0, 8), (100.0, 8), (51.293, 20)])
def test_undivided_it_emits_energy_and_the_worst_case_is_not_an_estimate(pole, rate_drop):
    # A wave that grows as the filter forgets: the singular vector of rest, cut off far away.
    params = FilterParams(kind="first_order", pole_rad_s=pole)
    ticks = np.arange(40_000)
    slow = np.sin(np.pi * (ticks + 0.5) / len(ticks))
    gain = worst_case_gain(params, tick_s=TICK_S, rate_drop=rate_drop)
    p = math.exp(-pole * TICK_S)
    h = (1 - p) * p ** np.arange(400)
    shaped = np.zeros(len(ticks))
    for n in range(rate_drop - 1, len(ticks), rate_drop):  # the adjoint of filter and drop
        reach = min(n + 1, len(h))
        shaped[n - reach + 1 : n + 1] += slow[n] * h[:reach][::-1]
    energy, balance = balances(params, shaped.tolist(), rate_drop)
    ratio = (energy[-1] - balance[-1]) / energy[-1]
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


FULL = 8
packet_trains = st.lists(st.tuples(amplitudes, st.integers(0, FULL)), min_size=1, max_size=40)


@pytest.mark.parametrize("kind", ["zoh", "foh"])
@given(train=packet_trains)
def test_a_hold_emits_no_more_than_it_got_while_no_packet_is_late(kind, train):
    packets, lengths = zip(*train, strict=True)
    received, _, least = expand(Held(kind, ticks=FULL), packets, lengths)
    assert least >= -1e-12 * received


@given(packets=st.lists(amplitudes, min_size=1, max_size=40))
def test_a_zero_order_hold_is_lossless_over_whole_frames(packets):
    received, emitted, _ = expand(Held("zoh", ticks=FULL), packets, [FULL] * len(packets))
    assert emitted == pytest.approx(received, rel=1e-12)


@pytest.mark.parametrize("kind", ["zoh", "foh"])
@given(v=amplitudes)
def test_a_late_packet_lets_any_hold_emit_more_than_it_got(kind, v):
    assume(v != 0.0)
    _, _, least = expand(Held(kind, ticks=FULL), [v, v], [FULL, 2 * FULL])
    assert least < 0.0


@pytest.mark.parametrize("ticks", [1, 2, 8, 20, 100])
def test_a_first_order_hold_stores_a_quarter_of_what_its_last_ticks_would_carry(ticks):
    # For any value c at the load and any packet v: M v^2 + s c^2 >= emitted + s (value after)^2,
    # s = (M-1)/2, as quadratic form in (c, v); for whole frames no smaller s would do.
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


@pytest.mark.parametrize("start", [-1.0, 0.5])
def test_first_order_hold_that_starts_elsewhere_generates_energy(start):
    held = Held("foh", ticks=FULL)
    held.load(start)
    for _ in range(FULL):
        held.step()
    _, _, least = expand(held, [0.0], [FULL])
    assert least < 0.0
