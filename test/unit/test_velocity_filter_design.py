# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Velocity filters: the conditions on their branches, and which filter meets them."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.filter_runs import BUTTERWORTH
from support.strategies import TICK_S, poles_rad_s

from pmwvc_core.errors import ParameterError
from pmwvc_core.params import FilterParams, MasterParams, VelocityFilterParams
from pmwvc_core.wave import velocity_filter_design as design
from pmwvc_core.wave.filter_design import sections_response
from reproduction.appendix_d import best_alpha, printed_branches
from reproduction.branches import branches, margins


@given(alpha=st.floats(0.05, 0.949))
def test_no_first_order_high_pass_suits_every_environment(alpha):
    # near rest the low pass falls with the square of the frequency, the high pass rises with it
    angle, low, high = printed_branches(alpha, points=2**17)
    found = margins(low, high, angle)
    assert found["any_environment_margin"] < 0.0
    reached = 1.0 - found["any_environment_margin"]
    assert reached**2 >= 1.0 - found["in_phase_margin"] - 1e-9


def test_the_flattest_in_phase_condition_is_near_the_published_alpha():
    assert best_alpha() == pytest.approx(0.9274, abs=5e-5)
    angle, low, high = printed_branches(0.92913)
    printed = margins(low, high, angle)
    angle, low, high = printed_branches(best_alpha())
    best = margins(low, high, angle)
    assert np.max(np.abs(best["in_phase"] - 1)) < np.max(np.abs(printed["in_phase"] - 1))


PRINTED_LOW = FilterParams(kind="first_order", pole_rad_s=float(-np.log(0.95) / TICK_S))
FREQUENCY_HZ = np.concatenate([np.geomspace(1e-4, 500.0, 6000), np.linspace(1.0, 500.0, 3000)])


def master(low=PRINTED_LOW, *, rate_drop=20, tick_s=TICK_S, kind="exact", **numbers):
    own = VelocityFilterParams(kind=kind, **numbers)
    return MasterParams(rate_drop=rate_drop, tick_s=tick_s, filter=low, velocity_filter=own)


def left(params):
    """Return both margins of a designed filter."""
    whole = design.chosen(params)
    low, high = branches(whole, FREQUENCY_HZ * 1e-3 / params.tick_s)
    share = params.velocity_filter.share
    found = margins(low, high, FREQUENCY_HZ, share=share)
    return found["in_phase_margin"], found["any_environment_margin"]


def noise_gain(params):
    """Noise of the difference of a rounded position in the force, beside that without a filter
    (rms, white); while nothing comes back (1 - s H)/(1 + s H), equivalent 1 - 2 s H.
    """
    own, turn = params.velocity_filter, np.arange(16384) / 16384
    sections = design.passing(params, "high")
    fed = own.share * design.sections_response(sections, 2.0 * np.pi * turn)
    gain = 1.0 - 2.0 * fed if own.in_force else (1.0 - fed) / (1.0 + fed)
    power = 4.0 * np.sin(np.pi * turn) ** 2  # |1 - 1/z|^2, on average 2
    return np.sqrt(np.mean(np.abs(gain) ** 2 * power) / 2.0)


def test_noise_of_an_encoder_in_the_force_with_the_published_filter():
    equivalent = master(kind="equivalent", order=1, alpha=0.929)
    assert noise_gain(equivalent) == pytest.approx(0.051, abs=5e-4)
    assert noise_gain(master(order=1, alpha=0.929)) == pytest.approx(0.318, abs=5e-4)


@given(
    pole=poles_rad_s,
    order=st.integers(2, 8),
    share=st.floats(0.05, 0.8),
    tick_s=st.sampled_from([2.5e-4, 1e-3, 4e-3]),
)
def test_any_order_from_two_on_has_a_cutoff_that_suits_every_environment(
    pole, order, share, tick_s
):
    params = master(
        FilterParams(kind="first_order", pole_rad_s=pole), order=order, share=share, tick_s=tick_s
    )
    try:
        in_phase, any_environment = left(params)
    except ParameterError as refused:
        assert "no high-pass filter of order" in str(refused)
        p = math.exp(-pole * tick_s)
        # what passes at half the tick rate, and how near to it the cut-off would have to be
        assert share + (1.0 - p) / (1.0 + p) > 1.0 or pole * tick_s > 0.1
        return
    assert any_environment >= -1e-7
    assert in_phase >= -1e-7


def test_the_lowest_cutoff_is_the_lowest():
    params = master(share=0.7)
    whole = design.chosen(params)
    own = whole.velocity_filter
    assert own.cutoff_hz == pytest.approx(14.54, abs=0.01)
    lower = dataclasses.replace(own, cutoff_hz=0.99 * own.cutoff_hz)
    assert left(params)[1] >= 0.0
    assert left(dataclasses.replace(params, velocity_filter=lower))[1] < -1e-4


def test_a_flatter_low_pass_needs_twice_its_order():
    with pytest.raises(ParameterError, match="twice that of the anti-aliasing filter"):
        left(master(BUTTERWORTH, order=3))
    assert left(master(BUTTERWORTH, order=8))[1] >= -1e-7


def test_what_cannot_be_designed_is_refused_by_name():
    with pytest.raises(ParameterError, match=r"filter\.kind = none"):
        design.passing(master(FilterParams(kind="none")), "high")
    with pytest.raises(ParameterError, match="cutoff_hz = 600"):
        design.passing(master(cutoff_hz=600.0), "high")
    with pytest.raises(ParameterError, match=r"share = 0\.99"):
        design.passing(master(share=0.99), "high")
    for numbers, said in (
        ({"alpha": 0.9, "cutoff_hz": 5.0}, "takes one of them"),
        ({"alpha": 0.9}, "order = 1"),
        ({"kind": "equivalent", "share": 0.6}, "must be <= 0.5"),
        ({"order": 1, "share": 1.0}, "must be < 1"),
    ):
        with pytest.raises(ParameterError, match=said):
            master(**numbers)


def test_the_filter_that_runs_has_the_flattest_alpha_near_the_published_one():
    """Its output after a tick already holds that tick: H_LP = 0.05 z/(z - 0.95)."""
    whole = design.chosen(master(order=1))
    assert whole.velocity_filter.alpha == pytest.approx(0.92969, abs=5e-6)
    assert left(master(order=1))[1] < 0.0


@given(order=st.integers(1, 4), cutoff_hz=st.floats(1.0, 400.0))
def test_a_complementary_pair_keeps_energy_at_every_frequency(order, cutoff_hz):
    params = master(kind="complementary", order=order, cutoff_hz=cutoff_hz)
    angle = np.linspace(1e-3, math.pi - 1e-3, 300)
    low, high = (
        sections_response(sos, angle)
        for sos in (design.passing(params, "low"), design.passing(params, "high"))
    )
    np.testing.assert_allclose(np.abs(low) ** 2 + np.abs(high) ** 2, 1.0, atol=1e-7)
