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
from support.strategies import signals

from pmwvc_core.errors import ParameterError
from pmwvc_core.master.port import WaveMaster
from pmwvc_core.params import BankParams, LocalModelParams
from pmwvc_core.wave.cascade import Cascade
from pmwvc_core.wave.design.bank_design import bank_filters

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
    filters = Cascade(signal.butter(order, 0.3, output="sos"))
    for u in waves:
        expected = filters.rest() + filters.gain * u
        assert filters.step(u) == pytest.approx(expected, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("kind", BANKS)
def test_the_force_fits_the_wave_that_the_parts_answer(kind):
    """v_m as it was promised is v_m as the filters then make it: the loop is solved."""
    port = WaveMaster(dataclasses.replace(master(kind), hold="zoh"))
    rng = np.random.default_rng(2)
    for _ in range(50):
        wave = rng.normal()
        port.receive(wave)
        before = port.v_m
        force = port.step(0.0, rng.normal())
        promised = port.v_m
        port.applied(force)
        bank = port._bank
        low = bank._low_down.y if bank._low_down else wave
        assert promised == pytest.approx(low + bank._high_down.y, rel=1e-9, abs=1e-12)
        assert promised != before


@given(
    motions=signals(longest=40),
    forces=st.lists(st.floats(-20.0, 20.0), min_size=40, max_size=40),
    kind=st.sampled_from(BANKS),
)
@settings(deadline=None)
def test_the_port_pays_for_what_the_limits_let_through(motions, forces, kind):
    port = WaveMaster(master(kind))
    given_j, size = 0.0, 1.0
    for xd, f in zip(motions.tolist(), forces, strict=False):
        port.receive(xd)
        port.step(0.0, xd)
        port.applied(f)
        given_j += f * xd * TICK_S
        size += abs(f * xd) + xd * xd
        kept = given_j + port.energy_v_m - port.energy_u_m
        assert kept >= -port.deficit_j - 1e-9 * size


@pytest.mark.parametrize("kind", BANKS)
def test_a_batch_moves_as_its_runs(kind):
    motions = np.random.default_rng(3).normal(size=(60, 3, 2))
    stiffness, impedance = np.array([[0.0], [500.0], [2e4]]), np.array([[10.0], [25.0], [60.0]])
    whole = driven(
        WaveMaster(master(kind, impedance=impedance, stiffness=stiffness)), motions, wave=0.3
    )
    for run in range(3):
        k, b = float(stiffness[run, 0]), float(impedance[run, 0])
        single = driven(
            WaveMaster(master(kind, impedance=b, stiffness=k)), motions[:, run], wave=0.3
        )
        np.testing.assert_allclose(whole[:, run], single, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("kind", BANKS)
def test_axes_do_not_disturb_one_another_up_to_six(kind):
    motions = np.random.default_rng(4).normal(size=(60, 6))
    together = driven(WaveMaster(master(kind)), motions)
    for axis in range(6):
        alone = driven(WaveMaster(master(kind)), motions[:, axis])
        np.testing.assert_allclose(together[:, axis], alone, rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize("kind", BANKS)
def test_a_matrix_impedance_acts_along_its_principal_axes(kind):
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    b = turn @ np.diag([40.0, 10.0]) @ turn.T
    text = "; ".join(" ".join(map(repr, row.tolist())) for row in b)
    motions = np.random.default_rng(5).normal(size=(60, 2))
    coupled = driven(WaveMaster(master(kind, matrix=text)), motions)
    for axis, impedance in enumerate((40.0, 10.0)):
        alone = driven(WaveMaster(master(kind, impedance=impedance)), motions @ turn[:, axis])
        np.testing.assert_allclose(coupled @ turn[:, axis], alone, rtol=1e-7, atol=1e-7)


def test_numbers_change_while_it_runs_and_accounts_go_on():
    params = master(stiffness=500.0, damping=1.0)
    port = WaveMaster(params)
    motions = np.random.default_rng(6).normal(size=40)
    driven(port, motions)
    before = dict(port.accounts)
    for change in (
        {"local_model": LocalModelParams(stiffness=4000.0, damping=0.0)},
        {"impedance": 40.0},
        {"bank": BankParams(kind="complementary", split_rad_s=70.0)},
        {"hold": "zoh"},
    ):
        params = dataclasses.replace(params, **change)
        port.configure(params)
        after = dict(port.accounts)
        held = {
            name: a["local_stored"] + a["local_dissipated"]
            for name, a in {"before": before, "after": after}.items()
        }
        assert held["after"] == pytest.approx(held["before"], rel=1e-12)
        assert all(after[f"bank_{n}"] == before[f"bank_{n}"] for n in ("low_in", "high_in"))
        driven(port, motions)
        before = dict(port.accounts)
        taken = before["bank_high_in"] - before["bank_high_out"]
        kept = before["local_stored"] + before["local_dissipated"]
        assert taken == pytest.approx(kept, rel=1e-9)
