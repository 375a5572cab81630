# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Velocity filters in the wave port: their transfer functions, energies, axes and runs."""

import dataclasses

import numpy as np
import pytest
from scipy import signal
from support.law_rigs import Port

from pmwvc_core.errors import ParameterError
from pmwvc_core.numeric import Array
from pmwvc_core.params import BankParams, FilterParams, MasterParams, VelocityFilterParams

TICK_S = 0.001
B = 30.0
ALPHA = 0.929
PRINTED = {"order": 1, "alpha": ALPHA}
FORMS = [
    {"kind": "exact", **PRINTED},
    {"kind": "exact", "order": 3, "share": 0.7},
    {"kind": "equivalent", **PRINTED},
    {"kind": "equivalent", "order": 2, "share": 0.4},
    {"kind": "complementary", "order": 1, "share": 1.0},
    {"kind": "complementary", "order": 2, "share": 0.8, "cutoff_hz": 30.0},
]


def master(rate_drop=8, **numbers):
    return MasterParams(
        impedance=B,
        rate_drop=rate_drop,
        hold="foh",
        filter=FilterParams(kind="first_order", pole_rad_s=51.3),
        velocity_filter=VelocityFilterParams(**numbers),
    )


def run(port, velocities, packets):
    """Return f_m, u_m, v_m, the filtered wave and the account, one row per tick."""
    rows = []
    for k, xd in enumerate(velocities):
        if k % 8 == 0:
            port.send()
            port.receive(packets[k // 8])
        f = port.step(0.0 * xd, xd)
        port.applied(f)
        account = list(port.energies.values())[-1]
        rows.append((f, port.u_m, port.v_m, port.u_m_lp, account))
    return rows


def drawn(axes=0, ticks=96):
    rng, shape = np.random.default_rng(8), (axes,) if axes else ()
    velocities, packets = rng.normal(0.0, 0.2, (ticks, *shape)), rng.normal(0.0, 1.0, (12, *shape))
    return (velocities, packets) if axes else (velocities.tolist(), packets.tolist())


def through(numerator, denominator, values):
    found: Array = signal.lfilter(numerator, denominator, values)
    return found


def test_the_exact_form_has_its_loop_solved():
    """F_m = b (1 - H/2)/(1 + H/2) xd - sqrt(2b) w/(1 + H/2), H = (z - 1)/(z - alpha)."""
    velocities, packets = drawn()
    plain, port = Port(master()), Port(master(kind="exact", **PRINTED))
    w = np.array([row[2] for row in run_plain(plain, velocities, packets)])
    above, below = np.array([1.0, -ALPHA]), np.array([1.0, -1.0])
    plus, minus = above + 0.5 * below, above - 0.5 * below
    expected = B * through(minus, plus, velocities) - np.sqrt(2 * B) * through(above, plus, w)
    rows = run(port, velocities, packets)
    np.testing.assert_allclose([row[0] for row in rows], expected, rtol=1e-9, atol=1e-11)
    u, v = np.array([row[1] for row in rows]), np.array([row[2] for row in rows])
    np.testing.assert_allclose(v - w, 0.5 * through(below, above, u), atol=1e-11)


def run_plain(port, velocities, packets):
    rows = []
    for k, xd in enumerate(velocities):
        if k % 8 == 0:
            port.receive(packets[k // 8])
        port.applied(port.step(0.0, xd))
        rows.append((port.s.f_m[0], port.u_m, port.v_m))
    return rows


def test_the_equivalent_form_filters_the_velocity_in_the_force_alone():
    """F_m = b (1 - alpha)/(z - alpha) xd - sqrt(2b) v_m (App. D Eq. 3), u_m as in Eq. 2."""
    velocities, packets = drawn()
    plain = run_plain(Port(master()), velocities, packets)
    rows = run(Port(master(kind="equivalent", **PRINTED)), velocities, packets)
    u, v = (np.array([row[place] for row in rows]) for place in (1, 2))
    np.testing.assert_array_equal(u, [row[1] for row in plain])
    np.testing.assert_array_equal(v, [row[2] for row in plain])
    low = through([0.0, 1.0 - ALPHA], [1.0, -ALPHA], velocities)
    np.testing.assert_allclose(
        [row[0] for row in rows], B * low - np.sqrt(2 * B) * v, rtol=1e-9, atol=1e-11
    )


@pytest.mark.parametrize("form", FORMS, ids=str)
def test_the_account_is_what_the_signals_give(form):
    """Kept: what came in at the device and from the server, less what went on and back."""
    velocities, packets = drawn()
    w = np.array([row[2] for row in run_plain(Port(master()), velocities, packets)])
    rows = run(Port(master(**form)), velocities, packets)
    f, u, v, lp, account = (np.array(column) for column in zip(*rows, strict=True))
    p = np.exp(-51.3 * TICK_S)
    on = np.diff(lp, prepend=0.0) * p / (1 - p) + lp  # the first-order filter undone
    if form["kind"] == "equivalent":
        kept = f * velocities - (u**2 - v**2) / 2
    else:
        kept = (u**2 - on**2 + w**2 - v**2) / 2
    np.testing.assert_allclose(account, np.cumsum(kept) * TICK_S, rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize("form", FORMS, ids=str)
def test_axes_side_by_side_are_each_its_own(form):
    velocities, packets = drawn(2)
    together = run(Port(master(**form), axes=2), velocities, packets)
    for axis in range(2):
        own = velocities[:, axis].tolist(), packets[:, axis].tolist()
        alone = run(Port(master(**form)), *own)
        for column in range(4):
            np.testing.assert_allclose(
                [row[column][axis] for row in together],
                [row[column] for row in alone],
                rtol=1e-9,
                atol=1e-12,
            )


def test_a_pair_that_splits_the_wave_itself_goes_with_no_bank():
    params = dataclasses.replace(
        master(kind="complementary"), bank=BankParams(kind="complementary")
    )
    with pytest.raises(ParameterError, match=r"bank\.kind = complementary"):
        Port(params)
