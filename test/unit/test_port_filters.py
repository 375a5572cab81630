# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Filter banks and velocity filters in the wave port: responses, the loop through the device,
accounts, axes, and changes while they run.
"""

import dataclasses

import numpy as np
import pytest
from scipy import signal
from support.port_parts import TICK_S, driven, master
from support.port_rig import Port

from pmwvc_core.errors import ParameterError
from pmwvc_core.params import BankParams, FilterParams, LocalModelParams, VelocityFilterParams
from pmwvc_core.wave.filter_design import bank_filters

BANKS = ("dissertation", "complementary")
ALPHA = 0.929
PRINTED = {"order": 1, "alpha": ALPHA}
FORMS = [
    {"kind": "exact", **PRINTED},
    {"kind": "exact", "order": 3, "share": 0.7},
    {"kind": "equivalent", **PRINTED},
    {"kind": "equivalent", "order": 2, "share": 0.4},
    {"kind": "complementary", "order": 2, "share": 0.8, "cutoff_hz": 30.0},
]
B, POLE_RAD_S = 30.0, 51.3


def loss_db(sos, frequency_hz):
    _, response = signal.sosfreqz(sos, [frequency_hz], fs=1.0 / TICK_S)
    return -20.0 * np.log10(np.abs(response[0]))


def test_the_filters_of_table_1_meet_their_edges():
    filters = bank_filters(BankParams(kind="dissertation"), tick_s=TICK_S)
    assert filters.low_up is filters.low_down is None
    assert loss_db(filters.high_up, 70.0) == pytest.approx(20.0, abs=1e-6)
    assert loss_db(filters.high_up, 40.0) >= 40.0
    assert loss_db(filters.high_down, 300.0) == pytest.approx(1.0, abs=1e-6)
    # orders 5 and 8: poles that are not at zero
    poles = [np.count_nonzero(sos[:, 4:6]) for sos in (filters.high_up, filters.high_down)]
    assert poles == [5, 8]


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"high_pass_hz": 30.0}, r"high_stop_hz = 40.0: must be < high_pass_hz = 30.0"),
        ({"low_pass_db": 50.0}, r"low_pass_db = 50.0: must be < low_stop_db = 40.0"),
        ({"split_rad_s": 0.0}, r"split_rad_s = 0.0: must be"),
        ({"kind": "three_bands"}, r"one of none, dissertation, complementary"),
        ({"kind": "dissertation", "low_pass_hz": 550.0}, r"bank.low_pass_hz = 550.0: .*< 500 Hz"),
        ({"kind": "dissertation", "high_stop_hz": 69.9}, r"bank.high_stop_hz = 69.9: .* apart"),
    ],
)
def test_filters_that_cannot_be_are_refused_by_name(wrong, words):
    with pytest.raises(ParameterError, match=words):
        bank_filters(BankParams(**wrong), tick_s=TICK_S)


def test_a_pair_that_splits_the_wave_itself_goes_with_no_bank():
    own = VelocityFilterParams(kind="complementary")
    params = dataclasses.replace(master("complementary"), velocity_filter=own)
    with pytest.raises(ParameterError, match=r"bank\.kind = complementary"):
        Port(params)


@pytest.mark.parametrize("kind", BANKS)
def test_the_force_fits_the_wave_that_the_parts_of_a_bank_answer(kind):
    """v_m as it was promised is v_m as scipy's filters then make it: the loop is solved."""
    params = dataclasses.replace(master(kind), hold="zoh")
    port, rng = Port(params), np.random.default_rng(2)
    filters = bank_filters(params.bank, tick_s=TICK_S)
    high_up, high_down = filters.high_up, filters.high_down
    waves, sent, promised, answered = [], [], [], []
    for _ in range(50):
        waves.append(float(rng.normal()))
        port.receive(waves[-1])
        came_j = port.energies["bank_high_out"]
        port.applied(port.step(0.0, float(rng.normal())))
        sent.append(port.u_m)
        promised.append(port.v_m)
        answered.append(np.sqrt(2.0 * (port.energies["bank_high_out"] - came_j) / TICK_S))
    down = waves if filters.low_down is None else signal.sosfilt(filters.low_down, waves)
    # The spring and damper of the local model, by the midpoint rule: v2 from u2.
    u2, x, v2 = signal.sosfilt(high_up, sent), 0.0, []
    gain = 500.0 * TICK_S / 2 + 1.0
    for wave in u2:
        free = np.sqrt(2.0 / 25.0) * wave
        force = (500.0 * x + gain * free) / (1.0 + gain / 25.0)
        x += TICK_S * (free - force / 25.0)
        v2.append(wave - np.sqrt(2.0 / 25.0) * force)
    np.testing.assert_allclose(np.abs(v2), answered, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(promised, down + signal.sosfilt(high_down, v2), rtol=1e-9)


def test_numbers_of_a_bank_change_while_it_runs_and_accounts_go_on():
    params = master(stiffness=500.0, damping=1.0)
    port = Port(params)
    motions = np.random.default_rng(6).normal(size=40).tolist()
    driven(port, motions)
    for change in (
        {"local_model": LocalModelParams(stiffness=4000.0, damping=0.0)},
        {"impedance": 40.0},
        {"bank": BankParams(kind="complementary", split_rad_s=70.0)},
        {"hold": "zoh"},
    ):
        before = port.energies
        params = dataclasses.replace(params, **change)
        port.configure(params)
        after = port.energies
        held = [each["local_stored"] + each["local_dissipated"] for each in (before, after)]
        assert held[0] == pytest.approx(held[1], rel=1e-12)
        assert all(after[f"bank_{n}"] == before[f"bank_{n}"] for n in ("low_in", "high_in"))
        driven(port, motions)
        now = port.energies
        kept = now["local_stored"] + now["local_dissipated"]
        assert now["bank_high_in"] - now["bank_high_out"] == pytest.approx(kept, rel=1e-9)


def filtered(**numbers):
    """Return a master of rate drop 8 with a velocity filter."""
    return dataclasses.replace(
        master("none", impedance=B, rate_drop=8),
        filter=FilterParams(kind="first_order", pole_rad_s=POLE_RAD_S),
        velocity_filter=VelocityFilterParams(**numbers),
    )


def run(params):
    """Return velocity, force, u_m, v_m, the filtered wave and the newest account by tick."""
    rng, port, rows = np.random.default_rng(8), Port(params), []
    velocities, packets = rng.normal(0.0, 0.2, 96).tolist(), rng.normal(size=12).tolist()
    for k, xd in enumerate(velocities):
        if k % 8 == 0:
            port.send()
            port.receive(packets[k // 8])
        f = port.step(0.0, xd)
        port.applied(f)
        rows.append((xd, f, port.u_m, port.v_m, port.u_m_lp, list(port.energies.values())[-1]))
    return np.array(rows).T


def through(numerator, denominator, values):
    return signal.lfilter(numerator, denominator, values)


def test_the_exact_form_has_its_loop_solved():
    """F_m = b (1 - H/2)/(1 + H/2) xd - sqrt(2b) w/(1 + H/2), H = (z - 1)/(z - alpha)."""
    _, _, _, w, *_ = run(filtered())
    xd, f, u, v, *_ = run(filtered(kind="exact", **PRINTED))
    above, below = np.array([1.0, -ALPHA]), np.array([1.0, -1.0])
    plus, minus = above + 0.5 * below, above - 0.5 * below
    expected = B * through(minus, plus, xd) - np.sqrt(2 * B) * through(above, plus, w)
    np.testing.assert_allclose(f, expected, rtol=1e-9, atol=1e-11)
    np.testing.assert_allclose(v - w, 0.5 * through(below, above, u), atol=1e-11)


def test_the_equivalent_form_filters_the_velocity_in_the_force_alone():
    """F_m = b (1 - alpha)/(z - alpha) xd - sqrt(2b) v_m (App. D Eq. 3), u_m as in Eq. 2."""
    _, _, *plain = run(filtered())
    xd, f, *waves = run(filtered(kind="equivalent", **PRINTED))
    np.testing.assert_array_equal(waves[:2], plain[:2])
    low = through([0.0, 1.0 - ALPHA], [1.0, -ALPHA], xd)
    np.testing.assert_allclose(f, B * low - np.sqrt(2 * B) * waves[1], rtol=1e-9, atol=1e-11)


@pytest.mark.parametrize("form", FORMS, ids=str)
def test_the_account_of_a_velocity_filter_is_what_the_signals_give(form):
    """Kept: what came in at the device and from the server, less what went on and back."""
    _, _, _, w, *_ = run(filtered())
    xd, f, u, v, lp, account = run(filtered(**form))
    p = np.exp(-POLE_RAD_S * TICK_S)
    on = np.diff(lp, prepend=0.0) * p / (1 - p) + lp  # the first-order filter undone
    kept = (u**2 - on**2 + w**2 - v**2) / 2
    if form["kind"] == "equivalent":
        kept = f * xd - (u**2 - v**2) / 2
    np.testing.assert_allclose(account, np.cumsum(kept) * TICK_S, rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize("form", [*BANKS, *FORMS], ids=str)
def test_behind_an_impedance_that_couples_the_axes_each_principal_axis_has_its_own(form):
    values, turn = (12.0, 60.0), np.array([[0.8, -0.6], [0.6, 0.8]])
    motions, local = np.random.default_rng(3).normal(size=(60, 2)), {"stiffness": 800.0}
    text = "; ".join(" ".join(map(repr, row)) for row in (turn * values @ turn.T).tolist())

    def made(**impedance):
        if isinstance(form, str):
            return master(form, **local, **impedance)
        own = VelocityFilterParams(**form)
        params = dataclasses.replace(master("none", **impedance), velocity_filter=own)
        return dataclasses.replace(params, filter=FilterParams(kind="first_order"))

    together = driven(Port(made(matrix=text), axes=2), motions @ turn.T, wave=0.3) @ turn
    for axis, value in enumerate(values):
        wave = 0.3 * turn.sum(axis=0)[axis]
        alone, other = (
            driven(Port(made(impedance=b)), motions[:, axis].tolist(), wave=wave)
            for b in (value, 1.2 * value)
        )
        np.testing.assert_allclose(together[:, axis], alone, rtol=1e-9, atol=1e-10)
        assert np.abs(together[:, axis] - other).max() > 1e-3  # the control
