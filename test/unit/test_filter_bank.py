# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Filter bank: its filters, the loop through the device, changes while it runs."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal
from support.bank_runs import TICK_S, driven, master
from support.law_rigs import Port
from support.strategies import signals

from pmwvc_core.errors import ParameterError
from pmwvc_core.law.wave.filter_and_hold import (
    cascade,
    gain_of,
    rest_of,
    resting_cascade,
    sections_of,
)
from pmwvc_core.params import BankParams, LocalModelParams
from pmwvc_core.wave.filter_design import bank_filters

BANKS = ("dissertation", "complementary")


def loss_db(sos, frequency_hz):
    _, response = signal.sosfreqz(sos, [frequency_hz], fs=1.0 / TICK_S)
    return -20.0 * np.log10(np.abs(response[0]))


def test_the_filters_of_table_1_meet_their_edges():
    filters = bank_filters(BankParams(kind="dissertation"), tick_s=TICK_S)
    assert filters.low_up is None
    assert filters.low_down is None
    assert loss_db(filters.high_up, 70.0) == pytest.approx(20.0, abs=1e-6)
    assert loss_db(filters.high_up, 40.0) >= 40.0
    assert loss_db(filters.high_down, 300.0) == pytest.approx(1.0, abs=1e-6)
    # orders 5 and 8: poles that are not at zero
    poles = [np.count_nonzero(sos[:, 4:6]) for sos in (filters.high_up, filters.high_down)]
    assert poles == [5, 8]


@given(pole=st.floats(0.01, 2000.0))
def test_the_complementary_pair_shares_the_power_of_every_frequency(pole):
    low, high, low_down, high_down = bank_filters(
        BankParams(kind="complementary", split_rad_s=pole), tick_s=TICK_S
    )
    frequency = np.linspace(0.0, 499.0, 50)
    power = [
        np.abs(signal.sosfreqz(sos, frequency, fs=1.0 / TICK_S)[1]) ** 2 for sos in (low, high)
    ]
    np.testing.assert_allclose(sum(power), 1.0, atol=1e-9)
    np.testing.assert_array_equal(low, low_down)
    np.testing.assert_array_equal(high, high_down)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"high_pass_hz": 30.0}, r"high_stop_hz = 40.0: must be < high_pass_hz = 30.0"),
        ({"low_pass_db": 50.0}, r"low_pass_db = 50.0: must be < low_stop_db = 40.0"),
        ({"split_rad_s": 0.0}, r"split_rad_s = 0.0: must be"),
        ({"kind": "three_bands"}, r"one of none, dissertation, complementary"),
    ],
)
def test_edges_out_of_order_are_refused_by_name(wrong, words):
    with pytest.raises(ParameterError, match=words):
        BankParams(**wrong)


def test_filters_that_cannot_be_are_refused_by_name():
    with pytest.raises(ParameterError, match=r"bank.low_pass_hz = 550.0: must be < 500 Hz"):
        bank_filters(BankParams(kind="dissertation", low_pass_hz=550.0), tick_s=TICK_S)
    with pytest.raises(ParameterError, match=r"bank.high_stop_hz = 69.9: .* apart"):
        bank_filters(BankParams(kind="dissertation", high_stop_hz=69.9), tick_s=TICK_S)


@given(waves=signals(longest=30), order=st.integers(1, 5))
def test_a_cascade_knows_its_output_up_to_the_input(waves, order):
    p = sections_of(signal.butter(order, 0.3, output="sos"))
    s = resting_cascade(p)
    for u in waves.tolist():
        expected = rest_of(s, p) + gain_of(p) * u
        s, y = cascade(s, u, p)
        assert y == pytest.approx(expected, rel=1e-9, abs=1e-9)


class Filter:
    """A filter of one axis, step by step."""

    def __init__(self, sos):
        self.p = sections_of(sos)
        self.s = resting_cascade(self.p)

    def peek(self, u):
        return cascade(self.s, u, self.p)[1]

    def __call__(self, u):
        self.s, y = cascade(self.s, u, self.p)
        return y


@pytest.mark.parametrize("kind", BANKS)
def test_the_force_fits_the_wave_that_the_parts_answer(kind):
    """v_m as it was promised is v_m as the filters then make it: the loop is solved."""
    params = dataclasses.replace(master(kind), hold="zoh")
    port, rng = Port(params), np.random.default_rng(2)
    high = Filter(bank_filters(params.bank, tick_s=TICK_S).high_down)
    low_down = bank_filters(params.bank, tick_s=TICK_S).low_down
    low = Filter(low_down) if low_down is not None else lambda v: v
    for _ in range(50):
        wave = float(rng.normal())
        port.receive(wave)
        before, came = port.v_m, port.energies["bank_high_out"]
        force = port.step(0.0, float(rng.normal()))
        promised = port.v_m
        port.applied(force)
        v2 = np.sqrt(2.0 * (port.energies["bank_high_out"] - came) / TICK_S)
        from_low, candidates = low(wave), (v2, -v2)  # its energy leaves the sign open
        found = [from_low + high.peek(v) for v in candidates]
        nearest = int(np.argmin(np.abs(np.array(found) - promised)))
        high(candidates[nearest])
        assert promised == pytest.approx(found[nearest], rel=1e-9, abs=1e-6)
        assert promised != before


@given(
    motions=signals(longest=40),
    forces=st.lists(st.floats(-20.0, 20.0), min_size=40, max_size=40),
    kind=st.sampled_from(BANKS),
)
@settings(deadline=None)
def test_the_port_pays_for_what_the_limits_let_through(motions, forces, kind):
    port = Port(master(kind))
    given_j, size = 0.0, 1.0
    for xd, f in zip(motions.tolist(), forces, strict=False):
        port.receive(xd)
        port.step(0.0, xd)
        port.applied(f)
        given_j += f * xd * TICK_S
        size += abs(f * xd) + xd * xd
        kept = given_j + port.energies["v_m"] - port.energies["u_m"]
        assert kept >= -port.s.deficit_j - 1e-9 * size


@pytest.mark.parametrize("kind", BANKS)
def test_axes_do_not_disturb_one_another(kind):
    motions = np.random.default_rng(4).normal(size=(60, 3))
    together = driven(Port(master(kind), axes=3), motions)
    for axis in range(3):
        alone = driven(Port(master(kind)), motions[:, axis].tolist())
        np.testing.assert_allclose(together[:, axis], alone, rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize("kind", BANKS)
def test_behind_an_impedance_that_couples_the_axes_each_principal_axis_has_its_own(kind):
    values, turn = (12.0, 60.0), np.array([[0.8, -0.6], [0.6, 0.8]])
    b = (turn @ np.diag(values) @ turn.T).tolist()
    text = "; ".join(" ".join(map(repr, row)) for row in b)
    motions = np.random.default_rng(3).normal(size=(60, 2))
    local = {"stiffness": 800.0, "damping": 3.0}
    together = driven(Port(master(kind, matrix=text, **local), axes=2), motions @ turn.T) @ turn
    for axis, value in enumerate(values):
        alone = driven(Port(master(kind, impedance=value, **local)), motions[:, axis].tolist())
        np.testing.assert_allclose(together[:, axis], alone, rtol=1e-10, atol=1e-10)
        other = driven(
            Port(master(kind, impedance=1.2 * value, **local)), motions[:, axis].tolist()
        )
        assert np.abs(together[:, axis] - other).max() > 1e-3  # the control


def test_numbers_change_while_it_runs_and_accounts_go_on():
    params = master(stiffness=500.0, damping=1.0)
    port = Port(params)
    motions = np.random.default_rng(6).normal(size=40).tolist()
    driven(port, motions)
    before = port.energies
    for change in (
        {"local_model": LocalModelParams(stiffness=4000.0, damping=0.0)},
        {"impedance": 40.0},
        {"bank": BankParams(kind="complementary", split_rad_s=70.0)},
        {"hold": "zoh"},
    ):
        params = dataclasses.replace(params, **change)
        port.configure(params)
        after = port.energies
        held = {
            name: a["local_stored"] + a["local_dissipated"]
            for name, a in {"before": before, "after": after}.items()
        }
        assert held["after"] == pytest.approx(held["before"], rel=1e-12)
        assert all(after[f"bank_{n}"] == before[f"bank_{n}"] for n in ("low_in", "high_in"))
        driven(port, motions)
        before = port.energies
        taken = before["bank_high_in"] - before["bank_high_out"]
        kept = before["local_stored"] + before["local_dissipated"]
        assert taken == pytest.approx(kept, rel=1e-9)
