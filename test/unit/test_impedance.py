# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The wave transformation behind a number or a matrix (App. B Fig. 1): what it computes, and which
texts are no impedance; contacts behind an impedance that couples the axes.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.strategies import impedances, matrices, power, signals_of

from pmwvc_core.errors import ParameterError
from pmwvc_core.law.server.contacts import attached, contact_force, slid, touching
from pmwvc_core.law.server.coupled_axes import coupled_answer
from pmwvc_core.law.server.coupling import solved_contact
from pmwvc_core.law.server.springs import depth
from pmwvc_core.law.wave.wave import (
    damper,
    free_velocity,
    rooted,
    wave_force,
    wave_u,
    wave_v,
    wave_velocity,
)
from pmwvc_core.made.server import contact_of
from pmwvc_core.made.waves import made_impedance, through
from pmwvc_core.params import ContactParams, MasterParams
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.wave.impedance import (
    FORCE_N,
    VELOCITY_M_S,
    MatrixImpedance,
    first_axis,
    impedance_of,
    largest_wave,
    parsed,
    server_impedance,
)

any_impedance = st.one_of(impedances, matrices(dof=3))


def scale_of(*signals):
    return 1e-9 * (1.0 + sum(np.abs(signal).max() ** 2 for signal in signals))


def work(f, xd):
    return np.sum(f * xd, -1, keepdims=True)


@settings(max_examples=30)
@given(b=matrices(), data=signals_of(1))
def test_force_and_waves_are_those_of_the_matrix_and_of_its_symmetric_root(b, data):
    (signal,) = data(b)
    matrix = b.matrix
    found = (through(law, b, signal) for law in (damper, rooted, free_velocity))
    force, wave, velocity = found
    np.testing.assert_allclose(force, signal @ matrix, atol=1e-9)
    np.testing.assert_allclose(through(rooted, b, wave), 2.0 * force, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(through(damper, b, velocity), wave, rtol=1e-6, atol=1e-9)
    once = b.with_values(np.sqrt(b.values))
    np.testing.assert_array_equal(once, once.T)
    np.testing.assert_allclose(once @ once, matrix, atol=1e-9 * np.abs(matrix).max())


@given(b=any_impedance, data=signals_of(2))
def test_both_ports_carry_the_power_of_force_and_velocity_and_fit_each_other(b, data):
    xd, v = data(b)
    u, f = through(wave_u, b, xd, v), through(wave_force, b, xd, v)
    np.testing.assert_allclose(power(u, v), work(f, xd), atol=scale_of(u, v))
    for law, wanted in ((wave_velocity, xd), (wave_v, v)):
        found = through(law, b, u, f)
        np.testing.assert_allclose(found, wanted, rtol=1e-6, atol=scale_of(u, f))
    v_s, xd_s = (through(law, b, xd, v) for law in (wave_v, wave_velocity))  # any wave, force
    np.testing.assert_allclose(power(xd, v_s), work(v, xd_s), atol=scale_of(xd, v_s))


@given(b=any_impedance, other=any_impedance, data=signals_of(2))
def test_ends_with_different_impedances_are_a_lossless_transformer(b, other, data):
    xd_s, f_s = data(b)
    u = 0.5 * through(free_velocity, b, f_s + through(damper, b, xd_s))
    v = through(wave_v, b, u, f_s)
    xd_m = 0.5 * through(free_velocity, other, u + v)
    f_m = through(wave_force, other, xd_m, v)
    np.testing.assert_allclose(work(f_m, xd_m), work(f_s, xd_s), atol=scale_of(u, v, f_m, xd_m))


def test_control_another_root_or_sign_does_not_carry_the_power():
    b, xd, v = parsed("30 8; 8 20"), np.array([0.1, -0.2]), np.array([0.4, 0.3])
    r = b.with_values(np.sqrt(2.0 * b.values))
    by_elements, of_cholesky = np.sqrt(2.0 * b.matrix), np.linalg.cholesky(2.0 * b.matrix)
    for to_u, to_f in ((by_elements,) * 2, (of_cholesky,) * 2, (r, -r)):
        u, f = to_u @ xd - v, b.matrix @ xd - to_f @ v
        assert power(u, v)[0] != pytest.approx(f @ xd, rel=1e-3)


@pytest.mark.parametrize(
    "text",
    [
        *("30 2; 2", "30 2 0; 2 20 0", ";", "30 2; 3 20", "30 40; 40 20", "-3", "1 0; 0 2e6"),
        *("30 x; 2 20", "inf 0; 0 1", "nan"),
    ],
)
def test_what_is_no_impedance_is_refused_by_name_and_value(text):
    words = f"'{text}': must be square, symmetric and positive definite"
    for kind in (MasterParams, ContactParams):
        with pytest.raises(ParameterError, match=f"^impedance_matrix = {words}"):
            kind(impedance_matrix=text)


def test_a_scenario_has_a_matrix_of_its_axes_or_takes_it_back():
    base = {"name": "m", "duration_s": 1, "controller": "pmwvc", "channel": "plain", "users": 1}
    for name in ("master", "server"):
        with pytest.raises(ParameterError, match=rf"{name}.impedance_matrix = .*2 20.*3 x 3"):
            parse_scenario(base, overrides={"dof": 3, f"{name}.impedance_matrix": "30 2; 2 20"})
    given = base | {"dof": 2, "master": {"impedance_matrix": "30 2; 2 20"}}
    assert isinstance(parse_scenario(given).users[0].impedance, MatrixImpedance)
    taken = parse_scenario(given, overrides={"master.impedance_matrix": None})
    assert taken.users[0].impedance == MasterParams().impedance


def test_a_server_port_has_one_impedance_and_by_default_the_masters():
    with pytest.raises(ParameterError, match="takes one of them"):
        ContactParams(impedance=3.0, impedance_matrix="30 2; 2 20")
    master = MasterParams(impedance_matrix="30 2; 2 20")
    assert server_impedance(ContactParams(), master) is impedance_of(master)
    assert server_impedance(ContactParams(impedance=3.0), master) == 3.0
    own = ContactParams(impedance_matrix="10 1; 1 9")
    np.testing.assert_allclose(server_impedance(own, master).matrix, [[10, 1], [1, 9]])


def test_what_is_read_and_shown_of_a_matrix():
    assert f"{parsed('30 6 0; 6 20 4; 0 4 25'):.4g}" == "[30 6 0; 6 20 4; 0 4 25]"
    assert f"{parsed('30 0; 0 20.25'):.4g} N s/m" == "[30 0; 0 20.25] N s/m"
    assert impedance_of(MasterParams(impedance_matrix=" 30 ")) == 30.0
    b = parsed("3, 1.0000000001; 1, 2").matrix  # digits lost in writing do not matter
    np.testing.assert_array_equal(b, b.T)


@settings(max_examples=30)
@given(b=matrices(), data=signals_of(2))
def test_no_wave_is_longer_than_force_and_velocity_allow(b, data):
    force, velocity = (
        s / np.maximum(np.linalg.norm(s, axis=-1, keepdims=True), 1e-9) for s in data(b)
    )
    whole = FORCE_N * force + through(damper, b, VELOCITY_M_S * velocity)
    u = 0.5 * through(free_velocity, b, whole)
    assert np.linalg.norm(u, axis=-1).max() <= largest_wave(b, waves=True) * (1.0 + 1e-9)
    one = (FORCE_N + 25.0 * VELOCITY_M_S) / np.sqrt(50.0)
    assert largest_wave(25.0, waves=True) == pytest.approx(one)
    along = np.eye(len(b.values))[0]
    assert first_axis(b) == pytest.approx(
        1.0 / np.linalg.solve(b.matrix, along)[0]
    )  # what a force along it meets


H = 0.008
contacts = st.builds(
    ContactParams,
    contact=st.sampled_from(["bilateral", "grip"]),
    contact_stiffness=st.floats(1.0, 5e3),
    contact_damping=st.floats(0.0, 50.0),
)
seeds = st.integers(0, 2**32 - 1)


def pressed(params, b, rng, *, side=1):
    """Return a contact that is anywhere near its face, and pulled sideways where it holds."""
    dof = len(b.values)
    contact = contact_of(params, side=side, size=0.06, axes=dof)
    contact = attached(contact, (side * 0.031, *(0.0,) * (dof - 1)))
    contact, _ = slid(contact, (-side * rng.uniform(0.0, 0.004), *(0.0,) * (dof - 1)))
    contact, _ = slid(contact, (0.0, *rng.normal(0.0, 0.002, dof - 1).tolist()))
    return contact


def answer_of(contact, free, b):
    """Return force, rate and slope as arrays."""
    answer = coupled_answer(contact, tuple(free.tolist()), made_impedance(b), H)
    return tuple(np.array(part) for part in answer)


def mean_normal(contact, rate):
    """Return the mean force of a one-sided contact over a step, from its potential."""
    law = contact.law
    p0 = depth(contact.springs[0], law)
    p1 = p0 + H * law.inward * rate
    inside = [max(p, 0.0) for p in (p0, p1)]
    spring = 0.5 * law.stiffness * (inside[1] ** 2 - inside[0] ** 2) / (p1 - p0)
    return law.inward * max(0.0, spring + law.damping * (inside[1] - inside[0]) / H)


@settings(max_examples=30)
@given(params=contacts, b=matrices(), side=st.sampled_from([-1, 1]), seed=seeds)
def test_the_mean_force_satisfies_contact_and_port(params, b, side, seed):
    rng = np.random.default_rng(seed)
    contact = pressed(params, b, rng, side=side)
    free = rng.normal(0.0, 0.3, len(b.values))
    force, rate, _ = answer_of(contact, free, b)
    scale = 1e-7 * (1.0 + np.abs(force).max())
    np.testing.assert_allclose(rate, free - np.linalg.solve(b.matrix, force), atol=1e-7)
    gain = 0.5 * H * params.contact_stiffness + params.contact_damping
    deflection = np.array([spring.deflection for spring in contact.springs])
    law = params.contact_stiffness * deflection + gain * rate
    if params.contact == "grip":
        law = np.where(touching(contact), law, 0.0)
        law[0] = mean_normal(contact, rate[0])
    np.testing.assert_allclose(force, law, rtol=1e-6, atol=scale)


@settings(max_examples=30)
@given(params=contacts, b=matrices(), weight=st.sampled_from([H, 0.5 * H]), seed=seeds)
def test_an_unwrapped_force_fits_the_velocity_it_leaves(params, b, weight, seed):
    rng = np.random.default_rng(seed)
    contact = pressed(params, b, rng)
    held = touching(contact)
    free, xd_o = rng.normal(0.0, 0.05, (2, len(b.values)))
    signals = tuple(free.tolist()), tuple(xd_o.tolist())
    force = np.array(solved_contact(made_impedance(b), contact, *signals, weight))
    xd = free - np.linalg.solve(b.matrix, force)
    contact, _ = slid(contact, tuple((weight * xd).tolist()))
    if held and touching(contact):
        expected = np.array(contact_force(contact, tuple((xd - xd_o).tolist())))
        if params.contact == "grip" and force[0] == 0.0:
            expected[0] = 0.0  # at the jump where the damper begins no force fits
        scale = 1e-7 * (1.0 + np.abs(expected).max())
        np.testing.assert_allclose(force, expected, rtol=1e-6, atol=scale)
