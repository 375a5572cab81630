# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""App. C: polynomials derived exactly, in fractions, against print, exact model and roots."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support import linear_loops

from pmwvc_analysis.models.linearize import build, spectral_radius
from reproduction.characteristic import (
    CASES,
    contact,
    jury_marden,
    loop_polynomial,
    plus,
    printed_polynomial,
    reflection,
    times,
)

numbers = st.fractions(Fraction(1, 50), Fraction(4), max_denominator=50)


def proportional(left, right):
    """Tell whether two polynomials have the same roots, exactly; leading zeros aside."""
    while left[0] == 0:
        left = left[1:]
    return len(left) == len(right) and all(
        a * right[0] == b * left[0] for a, b in zip(left, right, strict=True)
    )


def printed_diagram(case, alpha, beta, sigma):
    """Return the polynomial of the diagrams from which the printed ones follow."""
    numerator, denominator = reflection(case, alpha, beta, sigma)
    if case == "unwrapped":  # v_s(n) = u_s(n-1) - sqrt(2/b) F_s(n)
        h = contact(alpha, beta, sigma)
        numerator = plus(denominator, times([-2, 0], h))
        denominator = times(denominator, [1, 0])
    sent = plus(times(denominator, [1, 0]), numerator)
    force = plus(sent, times([-2, 0], numerator))
    return plus(times([1, -1], sent), times([beta], force))


@pytest.mark.parametrize("case", CASES)
@given(alpha=numbers, beta=numbers, sigma=st.fractions(0, 2, max_denominator=50))
def test_the_published_polynomials_are_those_of_their_diagrams(case, alpha, beta, sigma):
    derived = printed_diagram(case, alpha, beta, sigma)
    assert proportional(derived, printed_polynomial(case, alpha, beta, sigma))


@pytest.mark.parametrize("case", CASES)
def test_they_are_not_those_of_the_loop(case):
    values = Fraction(1, 2), Fraction(1, 3), Fraction(1, 7)
    assert not proportional(loop_polynomial(case, *values), printed_polynomial(case, *values))


def wall(case, alpha, beta, sigma):
    """A mass of 0.25 kg at a wall, one rate of 1 kHz, no filter."""
    m, t = 0.25, 1e-3
    return linear_loops.scenario(
        users=1,
        master__rate_drop=1,
        master__impedance=float(beta) * m / t,
        master__filter__kind="none",
        server__period_s=t,
        server__coupling=case,
        server__integrator="trapezoid",
        server__environment="wall",
        server__contact_stiffness=float(alpha) * m / t**2,
        server__contact_damping=float(sigma) * m / t,
    )


@pytest.mark.parametrize("case", CASES)
@settings(max_examples=12)
@given(alpha=numbers, beta=numbers, sigma=st.fractions(0, 2, max_denominator=50))
def test_the_exact_model_has_the_roots_of_our_polynomial(case, alpha, beta, sigma):
    roots = np.roots([float(c) for c in loop_polynomial(case, alpha, beta, sigma)])
    largest = np.abs(roots).max()
    assert spectral_radius(build(wall(case, alpha, beta, sigma))) == pytest.approx(
        largest, rel=1e-5
    )


def stable_share(of, case, sigma):
    alpha, beta = np.meshgrid(np.linspace(0.02, 2.0, 60), np.linspace(0.02, 1.9, 60))
    return np.mean(jury_marden(of(case, alpha, beta, sigma + 0.0 * alpha)))


def test_as_published_the_one_step_delay_shrinks_the_stable_region():
    late = stable_share(printed_polynomial, "one_step_delay", 0.0)
    assert 0.0 < late < 0.2 * stable_share(printed_polynomial, "unwrapped", 0.0)


def test_without_damping_the_loop_as_it_runs_has_no_stable_region_at_all():
    # A sampled mass gives out a little energy; lossless waves and an elastic wall take none.
    for case in CASES:
        assert stable_share(loop_polynomial, case, 0.0) == 0.0
        assert stable_share(loop_polynomial, case, 0.2) > 0.0
