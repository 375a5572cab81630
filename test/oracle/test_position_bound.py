# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Z_wall/Z_free <= coth^2(s tau/2) for every linear passive link with the round trip tau, at every
real s > 0; at rest K_ch/M_ch <= 4/tau^2: K_ch the spring through which a wall is felt, M_ch the
mass felt in free space.

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

WALL, FREE = -1.0, 1.0  # what the far end reflects: no velocity, no force
B, TAU = 25.0, 0.05
NEAR_REST = 1e-3  # [1/s], a real frequency: slow motion


def impedance(link, s, far, tau, b=B):
    """What the hand feels of the scattering matrix ``link(s)`` with waves behind it [N s/m].

    The delay lies between the matrix and the far end: there it leaves a contractive one so.
    """
    s11, s12, s21, s22 = link(s)
    late = far * np.exp(-s * tau)
    reflected = s11 + s12 * s21 * late / (1.0 - s22 * late)
    return b * (1.0 - reflected) / (1.0 + reflected)


def of_bound(link, s, tau, b=B):
    """Z_wall/Z_free as a share of coth^2(s tau/2)."""
    felt_wall, felt_free = (impedance(link, s, far, tau, b) for far in (WALL, FREE))
    return felt_wall / felt_free * np.tanh(s * tau / 2.0) ** 2


def felt(link, tau, b=B):
    """K_ch [N/m] and M_ch [kg] of a link."""
    s = NEAR_REST
    stiffness = [s * impedance(link, s, WALL, tau, b) for s in (s, s / 2)]
    mass = [impedance(link, s, FREE, tau, b) / s for s in (s, s / 2)]
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


def ladder(random, dampers=(0.0, 0.0, 0.0), slips=(0.0, 0.0, 0.0)):
    """Masses (and dampers) to ground and springs (and dampers) in series before waves at another
    impedance, as a scattering matrix at B; the far end is seen through the waves.
    """
    masses, softness = random.uniform(0.0, 1.0, 3), random.uniform(0.0, 1e-3, 3)
    ratio = random.uniform(0.2, 5.0)
    parts = list(zip(masses, softness, dampers, slips, strict=True))

    def link(s):
        chain = np.eye(2)
        for mass, soft, damper, slip in parts:
            chain = chain @ np.array([[1.0, mass * s + damper], [0.0, 1.0]])
            chain = chain @ np.array([[1.0, 0.0], [soft * s + slip, 1.0]])
        f_f, f_v, v_f, v_v = chain.ravel()  # (F, xd) at the device from those behind
        far = ratio * B
        total = f_f + f_v / far + B * v_f + B / far * v_v
        s11 = -(f_f + f_v / far - B * v_f - B / far * v_v) / total
        s22 = (f_f - f_v / far + B * v_f - B / far * v_v) / total
        through = 2.0 * np.sqrt(B / far) / total
        return s11, through, through, s22

    return link


def contractive(link):
    """Whether the link is passive: contractive on the axis."""
    rows = [np.reshape(link(w), (2, 2)) for w in 1j * np.logspace(-2, 4, 40)]
    return max(np.linalg.norm(row, 2) for row in rows) <= 1.0 + 1e-9


@pytest.mark.parametrize(("b", "tau"), [(25.0, 0.05), (5.0, 0.3), (80.0, 0.01)])
def test_wave_variables_attain_the_bound(b, tau):
    stiffness, mass = felt(waves, tau, b)
    assert stiffness == pytest.approx(2.0 * b / tau, rel=1e-4)
    assert mass == pytest.approx(b * tau / 2.0, rel=1e-4)
    assert stiffness / mass == pytest.approx(4.0 / tau**2, rel=1e-4)
    for s in np.geomspace(0.1, 10.0, 9) / tau:
        assert of_bound(waves, s, tau, b) == pytest.approx(1.0, rel=1e-9)


@pytest.mark.parametrize("family", [filtered, answered, ladder])
def test_a_wall_beside_free_space_is_bounded_at_every_real_frequency(family):
    random = np.random.default_rng(2)
    largest = 0.0
    for _ in range(400):
        link, tau = family(random), float(random.uniform(0.002, 0.3))
        assert contractive(link)
        shares = [of_bound(link, s, tau) for s in np.geomspace(0.01, 10.0, 25) / tau]
        largest = max(largest, *shares)
    assert largest <= 1.0 + 1e-9
    assert largest > 0.5  # the family comes near enough to mean something


@pytest.mark.parametrize("family", [filtered, answered, ladder])
def test_no_passive_link_beats_it(family):
    random = np.random.default_rng(1)
    best = 0.0
    for _ in range(400):
        link = family(random)
        assert contractive(link)
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
    assert of_bound(link, 10.0, TAU) > 1.5
