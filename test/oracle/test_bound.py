# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What a linear link with delay can render: Z_wall/Z_free <= coth^2(s tau/2) at every real s > 0,
whatever it is made of, as long as it is passive (docs/paper.md, section 5). At rest K_ch/M_ch <=
4/tau^2: K_ch the spring through which a wall is felt, M_ch the mass felt in free space.

Proof. For b > 0 let Gamma = (b - Z)/(b + Z). A held or free far end is lossless, so Z is positive
real and Gamma contractive. Before tau the port cannot know its far end, so both responses agree
until then::

    Gamma_free - Gamma_wall = e^(-s tau) G(s),   G analytic and bounded for Re s > 0

with |G| <= 2 on the axis, hence |G| <= 2 for Re s > 0. Let q = e^(-s tau) and r^2 = Z_wall/Z_free
> 1 at a real s > 0; b = sqrt(Z_wall Z_free) gives::

    Gamma_free - Gamma_wall = 2 (r - 1)/(r + 1) <= 2 q

and r <= (1 + q)/(1 - q) = coth(s tau/2).

Equations: docs/theory.md 11.8.
"""

import numpy as np
import pytest
from paper.links import FREE, WALL, End, Link, bound, random_link, wave_variables

PLACES = 10.0 ** np.linspace(-1.5, 1.0, 12)  # s tau


def largest(links):
    """Return the largest part of the bound that any of them reaches."""
    return max(
        link.ratio(place / link.round_trip_s) / bound(place, 1.0)
        for link in links
        for place in PLACES
    )


def made(count, gain=1.0, seed=7):
    rng = np.random.default_rng(seed)
    return [random_link(rng, gain) for _ in range(count)]


def test_no_passive_link_goes_beyond_the_bound():
    assert 0.9 < largest(made(400)) <= 1.0 + 1e-9


def test_wave_variables_attain_it_everywhere():
    link = wave_variables(0.04)
    for place in PLACES:
        assert link.ratio(place / 0.04) == pytest.approx(bound(place, 1.0), rel=1e-9)


def test_links_that_generate_energy_violate_it():
    """The control: the same links, each junction of which gives out 44 % more energy."""
    assert largest(made(400, gain=1.2)) > 1.1


def test_a_link_that_looks_ahead_violates_it():
    """The control of the delay: the same ends, the lines 20 % shorter than said."""
    link = wave_variables(0.8 * 0.04)
    assert all(link.ratio(place / 0.04) > 1.0001 * bound(place, 1.0) for place in PLACES)


def test_springs_dampers_and_masses_are_those_of_textbooks():
    """One-ports against closed forms: an outer port and one part, with no line to it."""
    s, b, a = 3.0, 20.0, 7.0
    for sign, expected in ((1.0, b * a / s), (-1.0, b * s / a)):  # spring b a, mass b/a
        swap = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
        part = End(swap, np.array([sign]), np.array([a]))
        loose = End(np.zeros((2, 2)), np.zeros(0), np.zeros(0))
        link = Link(part, loose, np.array([0.1]), np.array([0.1]), b)
        assert link.impedance_at(s, WALL) == pytest.approx(expected)
        assert link.impedance_at(s, FREE) == pytest.approx(expected)


def test_a_small_s_gives_stiffness_over_mass():
    link = wave_variables(0.05, impedance=30.0)
    s = 1e-3
    stiffness, mass = s * link.impedance_at(s, WALL), link.impedance_at(s, FREE) / s
    assert stiffness == pytest.approx(2.0 * 30.0 / 0.05, rel=1e-4)
    assert mass == pytest.approx(30.0 * 0.05 / 2.0, rel=1e-4)
    assert stiffness / mass == pytest.approx(4.0 / 0.05**2, rel=1e-3)
