# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""K_ch/M_ch <= 4/tau^2 for every linear passive link with the round trip tau (theory.md, section
11): K_ch the spring through which a wall is felt, M_ch the mass felt in free space.

Equations: docs/theory.md 11.8.
"""

import numpy as np
import pytest

WALL, FREE = -1.0, 1.0  # what the far end reflects: no velocity, no force
B, TAU = 25.0, 0.05
NEAR_REST = 1e-3  # [1/s], a real frequency: slow motion


def felt(link, tau, b=B):
    """K_ch [N/m] and M_ch [kg] of a link with the scattering matrix ``link(s)`` at both ends."""

    def impedance(s, far):
        s11, s12, s21, s22 = link(s)
        reflected = s11 + s12 * s21 * far * np.exp(-s * tau) / (1.0 - s22 * far)
        return b * (1.0 - reflected) / (1.0 + reflected)

    s = NEAR_REST
    stiffness = [s * impedance(s, WALL) for s in (s, s / 2)]
    mass = [impedance(s, FREE) / s for s in (s, s / 2)]
    return 2 * stiffness[1] - stiffness[0], 2 * mass[1] - mass[0]  # what is of first order in s


def waves(s):
    """Wave variables: what comes in goes to the other end."""
    return 0.0, 1.0, 1.0, 0.0


def low_pass(random):
    """A random mean of first-order filters and delays: |H| <= 1, H = 1 at rest."""
    shares = random.dirichlet(np.ones(3))
    poles, delays = random.uniform(5.0, 2000.0, 3), random.uniform(0.0, 0.05, 3)
    return lambda s: np.sum(shares * poles / (s + poles) * np.exp(-s * delays))


def filtered(random):
    """Filters on both ways."""
    up, down = low_pass(random), low_pass(random)
    return lambda s: (0.0, down(s), up(s), 0.0)


def answered(random):
    """Part of the fast wave is answered at once, by a pair of filters that keeps energy."""
    pole, share = random.uniform(5.0, 2000.0), random.uniform(-1.0, 1.0)
    far, other = random.uniform(5.0, 2000.0), random.uniform(-1.0, 1.0)
    rest = low_pass(random)

    def link(s):
        low, high = pole / (s + pole), s / (s + pole)
        low_far, high_far = far / (s + far), s / (s + far)
        through = low * low_far * rest(s)
        return share * high**2, through, through, other * high_far**2

    return link


def ladder(random):
    """Masses to ground and springs in series before waves at another impedance, as a scattering
    matrix at B; the far end is seen through the waves.
    """
    masses, softness = random.uniform(0.0, 1.0, 3), random.uniform(0.0, 1e-3, 3)
    ratio = random.uniform(0.2, 5.0)

    def link(s):
        chain = np.eye(2)
        for mass, soft in zip(masses, softness, strict=True):
            chain = chain @ np.array([[1.0, mass * s], [0.0, 1.0]])
            chain = chain @ np.array([[1.0, 0.0], [soft * s, 1.0]])
        f_f, f_v, v_f, v_v = chain.ravel()  # (F, xd) at the device from those behind
        far = ratio * B
        total = f_f + f_v / far + B * v_f + B / far * v_v
        s11 = -(f_f + f_v / far - B * v_f - B / far * v_v) / total
        s22 = (f_f - f_v / far + B * v_f - B / far * v_v) / total
        through = 2.0 * np.sqrt(B / far) / total
        return s11, through, through, s22

    return link


@pytest.mark.parametrize(("b", "tau"), [(25.0, 0.05), (5.0, 0.3), (80.0, 0.01)])
def test_wave_variables_attain_the_bound(b, tau):
    stiffness, mass = felt(waves, tau, b)
    assert stiffness == pytest.approx(2.0 * b / tau, rel=1e-4)
    assert mass == pytest.approx(b * tau / 2.0, rel=1e-4)
    assert stiffness / mass == pytest.approx(4.0 / tau**2, rel=1e-4)


@pytest.mark.parametrize("family", [filtered, answered, ladder])
def test_no_passive_link_beats_it(family):
    random = np.random.default_rng(1)
    best = 0.0
    for _ in range(400):
        link = family(random)
        for w in 1j * np.logspace(-2, 4, 40):  # contractive on the axis: passive
            s11, s12, s21, s22 = link(w)
            assert np.linalg.norm([[s11, s12], [s21, s22]], 2) <= 1.0 + 1e-9
        stiffness, mass = felt(link, TAU)
        assert 1.0 / stiffness > 0.0
        assert mass > 0.0
        best = max(best, stiffness / mass * TAU**2 / 4.0)
    assert best <= 1.0 + 1e-6
    assert best > 0.05  # the family comes near enough to mean something


def test_a_link_that_makes_energy_beats_it():
    """The control: phase lead on the way up, more than 1 at high frequencies."""
    lead_s = 0.02

    def link(s):
        return 0.0, 1.0, (1.0 + lead_s * s) / (1.0 + 1e-4 * s), 0.0

    assert abs(link(100j)[2]) > 1.0
    stiffness, mass = felt(link, TAU)
    assert stiffness / mass > 1.5 * 4.0 / TAU**2
