# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The anti-aliasing filter: its cut-off, its output, its delay, and what the rate drop behind it
does with energy; Butterworth filters in closed form are those of scipy, without its import.
"""

import math
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy import signal
from support.filter_runs import BUTTERWORTH, KINDS, run
from support.strategies import TICK_S

from pmwvc_core.errors import ParameterError
from pmwvc_core.params import FilterParams
from pmwvc_core.simulation.session import simulate_one
from pmwvc_core.wave.aliasing import delay_of, warnings_of, worst_case_gain
from pmwvc_core.wave.filter_design import (
    HIGHEST_ORDER,
    bilinear_sections,
    design,
    half_power_hz,
    least_order,
    order_of,
    pole_of,
    response,
)
from reproduction import down_sampler

AT = {"tick_s": TICK_S, "rate_drop": 8}


def loss_db(sos, hz):
    return -20.0 * math.log10(abs(signal.sosfreqz(sos, [2.0 * math.pi * hz * TICK_S])[1][0]))


def butterworth(pass_hz=25.0, stop_hz=50.0, **values):
    return FilterParams(kind="butterworth", pass_hz=pass_hz, stop_hz=stop_hz, **values)


def first_order(**values):
    return FilterParams(kind="first_order", **values)


def test_the_three_conventions_name_the_same_filter():
    """A pole [rad/s] (by default that of App. B), -3 dB, -20 dB [Hz]."""
    pole = 70.0
    at_3_db = pole / (2.0 * math.pi)
    at_20_db = at_3_db * math.sqrt(99.0)
    assert pole_of(first_order()) == 50.0
    for values in ({"pole_rad_s": pole}, {"cutoff_hz": at_3_db}, {"stop_hz": at_20_db}):
        assert pole_of(first_order(**values)) == pytest.approx(pole)


@pytest.mark.parametrize("meet", ["pass", "stop"])
@pytest.mark.parametrize(
    ("edges", "losses", "order"),
    [
        ((25, 50), (20, 40), 4),
        ((20, 200), (3, 20), 1),
        ((150, 200), (20, 40), 7),
        ((250, 300), (20, 40), 8),
    ],
)
def test_a_bilinear_butterworth_of_a_table_is_scipys(meet, edges, losses, order):
    """It meets one edge exactly and keeps the other; its order is the least of the sampled filter
    (the analogue one is larger: the bilinear transform moves high edges apart).
    """
    params = butterworth(*edges, pass_db=losses[0], stop_db=losses[1], meet=meet)
    sos, place = design(params, tick_s=TICK_S), meet == "stop"
    sampled, _ = signal.buttord(*edges, *losses, fs=1 / TICK_S)
    analogue, _ = signal.buttord(*edges, *losses, analog=True)
    assert order_of(params, tick_s=TICK_S) == order == sampled
    assert analogue > order or edges[0] < 150
    warped = np.tan(np.pi * edges[place] * TICK_S)
    warped /= (10.0 ** (0.1 * losses[place]) - 1.0) ** (0.5 / order)
    cutoff_hz = np.arctan(warped) / np.pi / TICK_S
    expected = signal.butter(order, cutoff_hz, fs=1 / TICK_S, output="sos")
    found = [signal.sosfreqz(each, np.linspace(0.0, 3.1, 200))[1] for each in (sos, expected)]
    np.testing.assert_allclose(*found, atol=1e-12)
    assert loss_db(sos, edges[place]) == pytest.approx(losses[place], abs=1e-9)
    assert loss_db(sos, edges[0]) <= losses[0] + 1e-9
    assert loss_db(sos, edges[1]) >= losses[1] - 1e-9
    assert loss_db(sos, half_power_hz(params, tick_s=TICK_S)) == pytest.approx(3.0103, abs=1e-4)


def test_an_edge_beyond_half_the_tick_rate_sets_the_analogue_order_and_cannot_be_met():
    low = {"pass_db": 1.0, "stop_db": 40.0}
    params = butterworth(300.0, 600.0, **low)
    assert order_of(params, tick_s=TICK_S) == 8
    assert loss_db(design(params, tick_s=TICK_S), 300.0) == pytest.approx(1.0, abs=1e-9)
    for values, words in (
        ((200.0, 600.0, "stop"), r"stop_hz = 600.*must be < 500 Hz.*meet the other edge"),
        ((49.9, 50.0, "pass"), r"of order \d+, more than 20; move the edges apart"),
    ):
        with pytest.raises(ParameterError, match=words):
            design(butterworth(*values[:2], meet=values[2]), tick_s=TICK_S)


@pytest.mark.parametrize("params", KINDS, ids=lambda p: p.kind)
def test_packets_of_a_constant_of_a_ramp_and_of_anything(params):
    """The first packet is zero; a constant passes; a ramp comes out behind by the delay; a packet
    is the output after the last tick, or the mean of the frame.
    """
    _, packets = run(params, [0.7] * 4000)
    assert packets[0] == 0.0
    assert packets[-1] == pytest.approx(0.7, rel=1e-9)
    ticks, packets = run(params, np.arange(4000.0).tolist())
    last = packets[-1] if params.kind == "integrate_and_dump" else ticks[3991]
    assert delay_of(params, **AT) == pytest.approx((3991.0 - last) * TICK_S, abs=1e-9)
    u = np.random.default_rng(3).normal(size=81)
    ticks, packets = run(params, u.tolist())
    if params.kind == "integrate_and_dump":
        np.testing.assert_allclose(packets[1:], u[:80].reshape(10, 8).mean(axis=1), rtol=1e-12)
    else:
        assert packets[1:] == ticks[7:80:8]


@pytest.mark.parametrize("kind", ["none", "integrate_and_dump", "first_order"])
def test_the_response_is_that_of_the_running_filter(kind):
    params = first_order(pole_rad_s=50.0) if kind == "first_order" else FilterParams(kind=kind)
    pulse = np.zeros(1024)
    pulse[0] = 1.0
    if kind == "integrate_and_dump":
        answer = np.where(np.arange(1024) < 8, 1 / 8, 0.0)
    else:
        answer = run(params, pulse.tolist())[0]
    found = response(params, np.fft.rfftfreq(1024, TICK_S), **AT)
    np.testing.assert_allclose(found, np.fft.rfft(answer), atol=1e-9)


@pytest.mark.parametrize("params", [KINDS[1], BUTTERWORTH], ids=lambda p: p.kind)
@pytest.mark.parametrize("rate_drop", [3, 20])
def test_the_worst_case_is_the_largest_singular_value_of_filter_and_drop(params, rate_drop):
    """Impulse responses to every tick before the last packet, one row per packet."""
    ticks = 1200
    h, _ = run(params, [1.0, *[0.0] * (ticks - 1)])
    instants = np.arange(rate_drop - 1, ticks, rate_drop)
    rows = np.zeros((len(instants), ticks))
    for row, instant in enumerate(instants):
        rows[row, : instant + 1] = h[instant::-1]
    largest = rate_drop * np.linalg.norm(rows, 2) ** 2
    gain = worst_case_gain(params, tick_s=TICK_S, rate_drop=rate_drop)
    assert largest <= gain * (1.0 + 1e-12)
    assert largest == pytest.approx(gain, rel=5e-3)


def test_what_aliases_is_named_with_its_worst_case():
    (text,) = warnings_of(first_order(cutoff_hz=62.6), **AT)
    gain = worst_case_gain(first_order(cutoff_hz=62.6), **AT)
    for words in ("62.6 Hz (-3 dB)", "half the packet rate (62.5 Hz)", f"{gain:.4g} times"):
        assert words in text
    (text,) = warnings_of(FilterParams(kind="none"), **AT)
    assert "there is no filter" in text and "8 times" in text
    assert warnings_of(first_order(cutoff_hz=62.4), **AT) == []
    assert warnings_of(FilterParams(kind="none"), tick_s=TICK_S, rate_drop=1) == []
    assert warnings_of(FilterParams(kind="integrate_and_dump"), **AT) == []


SHORT = {"duration_s": 3.0, "operator.frequency_hz": 2.0}


def test_the_account_of_app_a_figure_8_is_that_of_the_filtered_wave_and_its_samples():
    scenario = down_sampler.printed_scenario(**SHORT)
    found = down_sampler.energy_over_cut_off(scenario, [butterworth()])
    traces = simulate_one(down_sampler.with_filter(scenario, butterworth()))
    frames = traces.users[0].u_m_lp[:, 0].reshape(-1, 20)
    sent = np.concatenate([[0.0], frames[:-1, -1]])  # the output after the last tick
    kept = np.cumsum(np.sum(frames**2, axis=1)) - np.sum(frames**2, axis=1)
    expected = 0.5e-3 * (kept - 20 * np.cumsum(sent**2))
    np.testing.assert_allclose(found["left_j"][0], expected, atol=1e-15)
    assert found["minimum_j"][0] == pytest.approx(expected.min())
    assert found["final_j"][0] == pytest.approx(expected[-1])


ANGLES = np.linspace(0.0, 3.14, 400)


@pytest.mark.parametrize("side", ["low", "high"])
@pytest.mark.parametrize("order", range(1, 13))
@pytest.mark.parametrize("cutoff_hz", [7.0, 15.9, 60.0, 200.0, 450.0])
def test_bilinear_sections_respond_as_scipys(order, cutoff_hz, side):
    cutoff = 2.0 / TICK_S * np.tan(np.pi * cutoff_hz * TICK_S)
    ours = bilinear_sections(order, cutoff, TICK_S, side)
    theirs = signal.butter(order, cutoff_hz, side, fs=1.0 / TICK_S, output="sos")
    values = [signal.sosfreqz(sos, ANGLES)[1] for sos in (ours, theirs)]
    np.testing.assert_allclose(values[0], values[1], atol=1e-12)


@given(
    edges=st.tuples(st.floats(1.0, 400.0), st.floats(1.0, 400.0)),
    losses=st.tuples(st.floats(0.1, 80.0), st.floats(0.1, 80.0)),
)
def test_the_least_order_is_scipys(edges, losses):
    low, high = sorted(edges)
    little, much = sorted(losses)
    assume(high / low > 1.01 and much - little > 0.01)
    for pass_hz, stop_hz in ((low, high), (high, low)):
        expected, _ = signal.buttord(pass_hz, stop_hz, little, much, analog=True)
        if expected > HIGHEST_ORDER:
            with pytest.raises(ParameterError, match=f"is of order {expected:.0f},"):
                least_order(pass_hz, little, stop_hz, much)
        else:
            assert least_order(pass_hz, little, stop_hz, much) == expected


def test_filter_questions_do_not_import_scipys_signal_processing():
    program = (
        "import sys\n"
        "from pmwvc_core.params import FilterParams\n"
        "from pmwvc_core.wave.aliasing import delay_of, warnings_of, worst_case_gain\n"
        "one = FilterParams(kind='butterworth', pass_hz=25.0, stop_hz=50.0)\n"
        "for ask in (delay_of, warnings_of, worst_case_gain):\n"
        "    ask(one, tick_s=1e-3, rate_drop=8)\n"
        "print([name for name in sys.modules if name.split('.')[0] == 'scipy'])\n"
    )
    found = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert found.stdout.strip() == "[]"
