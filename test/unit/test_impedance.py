# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A matrix impedance: what it computes, and which texts are refused."""

import numpy as np
import pytest
from hypothesis import given, settings
from support.strategies import matrices, signals_of
from support.wave_power import power

from pmwvc_core.errors import ParameterError
from pmwvc_core.numeric import root
from pmwvc_core.params import ContactParams, MasterParams
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.wave.impedance import (
    MatrixImpedance,
    WavePort,
    first_axis,
    impedance_of,
    longest_wave,
    parsed,
    server_impedance,
)


def scale_of(*signals):
    return 1e-9 * (1.0 + sum(np.abs(signal).max() ** 2 for signal in signals))


@settings(max_examples=60)
@given(b=matrices(), data=signals_of(2))
def test_the_operators_are_those_of_the_matrix(b, data):
    signal, other = data(b)
    matrix = b.matrix
    np.testing.assert_allclose(b * signal, signal @ matrix, atol=1e-9)
    np.testing.assert_allclose(signal * b, b * signal)
    inverse = np.linalg.inv(matrix)
    np.testing.assert_allclose(signal / b, signal @ inverse, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose((2.0 * b).matrix, 2.0 * matrix, atol=1e-9)
    np.testing.assert_allclose((b / 2.0).matrix, 0.5 * matrix, atol=1e-9)
    np.testing.assert_allclose((2.0 / b).matrix, 2.0 * inverse, rtol=1e-6, atol=1e-9)
    once = root(b).matrix
    np.testing.assert_array_equal(once, once.T)
    np.testing.assert_allclose(once @ once, matrix, atol=1e-9 * np.abs(matrix).max())
    np.testing.assert_array_equal(b * (0.0 * other), 0.0 * other)
    assert b * 0.0 == 0.0 / b == 0.0


@settings(max_examples=60)
@given(b=matrices(), data=signals_of(2))
def test_both_ports_carry_the_power_of_force_and_velocity(b, data):
    xd, v = data(b)
    u, f = WavePort(b).u(xd, v), WavePort(b).force(xd, v)
    np.testing.assert_allclose(power(u, v), np.sum(f * xd, -1, keepdims=True), atol=scale_of(u, v))
    u_s, f_s = data(b)
    v_s, xd_s = WavePort(b).v(u_s, f_s), WavePort(b).velocity(u_s, f_s)
    np.testing.assert_allclose(
        power(u_s, v_s), np.sum(f_s * xd_s, -1, keepdims=True), atol=scale_of(u_s, v_s)
    )


@settings(max_examples=60)
@given(b=matrices(), data=signals_of(2))
def test_a_server_that_answers_with_the_master_force_moves_with_the_master(b, data):
    xd, v = data(b)
    u, f = WavePort(b).u(xd, v), WavePort(b).force(xd, v)
    np.testing.assert_allclose(WavePort(b).velocity(u, f), xd, rtol=1e-6, atol=scale_of(u, f))
    np.testing.assert_allclose(WavePort(b).v(u, f), v, rtol=1e-6, atol=scale_of(u, f))


@settings(max_examples=40)
@given(b=matrices(dof=3), other=matrices(dof=3), data=signals_of(2))
def test_ends_with_different_matrices_are_a_lossless_transformer(b, other, data):
    xd_s, f_s = data(b)
    u = (f_s + b * xd_s) / root(2.0 * b)
    v = WavePort(b).v(u, f_s)
    xd_m = (u + v) / root(2.0 * other)
    f_m = WavePort(other).force(xd_m, v)
    np.testing.assert_allclose(
        np.sum(f_m * xd_m, -1), np.sum(f_s * xd_s, -1), atol=scale_of(u, v, f_m, xd_m)
    )


class RootByElements(MatrixImpedance):
    """The naive one: correct for diagonal matrices only."""

    def root(self):
        return Dense(np.sign(self.matrix) * np.sqrt(np.abs(self.matrix)))


class CholeskyRoot(RootByElements):
    """R^T R = B, but not symmetric: used as if it were."""

    def root(self):
        return Dense(np.linalg.cholesky(self.matrix))


class Dense:
    """Any matrix that acts on rows of signals."""

    __array_ufunc__ = None

    def __init__(self, matrix):
        self.matrix = matrix

    def __mul__(self, signal):
        return signal @ self.matrix.T


@pytest.mark.parametrize("wrong", [RootByElements, CholeskyRoot])
def test_another_root_does_not_carry_the_power(wrong):
    right = parsed("30 8; 8 20")
    b = wrong(right.values, right.axes)
    xd, v = np.array([0.1, -0.2]), np.array([0.4, 0.3])
    f = WavePort(b).force(xd, v)
    assert power(WavePort(b).u(xd, v), v)[0] != pytest.approx(f @ xd, rel=1e-3)
    f = WavePort(right).force(xd, v)
    assert power(WavePort(right).u(xd, v), v)[0] == pytest.approx(f @ xd, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("30 2; 2", "'30 2; 2': must be numbers, rows of one length"),
        ("30 2 0; 2 20 0", "must be 2 x 2"),
        ("30 2; 3 20", "must be symmetric"),
        ("30 40; 40 20", "must be positive definite"),
        ("0", "must be positive definite"),
        ("-3", "must be positive definite"),
        ("1 0; 0 2e6", "condition number of at most 1e\\+06"),
        ("30 x; 2 20", "must be numbers"),
        ("inf 0; 0 1", "must be of finite numbers"),
        ("nan", "must be of finite numbers"),
        (";", "must be 2 x 2"),
    ],
)
def test_what_is_no_impedance_is_refused_by_name_and_value(text, words):
    for kind in (MasterParams, ContactParams):
        with pytest.raises(ParameterError, match=f"^impedance_matrix = .*{words}"):
            kind(impedance_matrix=text)


ONE_USER = {
    "name": "m",
    "duration_s": 1,
    "controller": "pmwvc",
    "channel": "plain",
    "users": 1,
}


def test_a_scenario_tells_a_matrix_of_the_wrong_size():
    base = ONE_USER | {"dof": 3}
    for name in ("master", "server"):
        with pytest.raises(ParameterError, match=rf"{name}.impedance_matrix = .*3 x 3.*2 x 2"):
            parse_scenario(base, overrides={f"{name}.impedance_matrix": "30 2; 2 20"})


def test_a_matrix_is_taken_back_by_a_name_with_nothing_behind_it():
    base = ONE_USER | {"dof": 2}
    given = base | {"master": {"impedance_matrix": "30 2; 2 20"}}
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


def test_a_line_of_text_has_the_matrix():
    b = parsed("30 6 0; 6 20 4; 0 4 25")
    assert f"{b:.4g}" == "[30 6 0; 6 20 4; 0 4 25]"
    b = parsed("30 0; 0 20.25")
    assert f"{b:.4g} N s/m" == "[30 0; 0 20.25] N s/m"


def test_one_axis_is_a_number_and_digits_lost_in_writing_do_not_matter():
    assert impedance_of(MasterParams(impedance_matrix=" 30 ")) == 30.0
    assert impedance_of(MasterParams(impedance=7.0)) == 7.0
    np.testing.assert_array_equal(
        parsed("3, 1.0000000001; 1, 2").matrix, parsed("3, 1.0000000001; 1, 2").matrix.T
    )


def test_what_a_force_along_the_first_axis_meets():
    b = parsed("30 8; 8 20")
    velocity = np.array([1.0, 0.0]) / b
    assert first_axis(b) == pytest.approx(1.0 / velocity[0])
    assert first_axis(25.0) == 25.0


@settings(max_examples=30)
@given(b=matrices(), data=signals_of(2))
def test_no_wave_is_longer_than_force_and_velocity_allow(b, data):
    force, velocity = (
        s / np.maximum(np.linalg.norm(s, axis=-1, keepdims=True), 1e-9) for s in data(b)
    )
    u = (20.0 * force + b * (1.5 * velocity)) / root(2.0 * b)
    assert np.linalg.norm(u, axis=-1).max() <= longest_wave(b, 20.0, 1.5) * (1.0 + 1e-9)
    assert longest_wave(25.0, 20.0, 1.5) == pytest.approx((20.0 + 25.0 * 1.5) / np.sqrt(50.0))
