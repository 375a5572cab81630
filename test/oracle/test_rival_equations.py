# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Rivals of the benchmark: the equations of their papers."""

import math

import numpy as np
import pytest
from benchmark.rivals import (
    deadband_tdpa,
    energy,
    model_mediated,
    two_layer,
)
from support.rival_link import FRAME_S, TICK_S, K, RivalLink, made, series


def test_a_sum_counts_from_when_it_is_first_heard_and_not_across_lives():
    s, gained = energy.received(energy.Received(), 0.3)
    rows = [gained]
    for sum_j in (0.3, 0.5, 0.1, 0.2):  # repeated, grown, started again, grown
        s, gained = energy.received(s, sum_j)
        rows.append(gained)
    assert rows == pytest.approx([0.0, 0.0, 0.2, 0.0, 0.1])


def test_two_tanks_that_share_become_equal_and_nothing_is_lost():
    """Simple energy transfer: after n steps apart H (1 - beta)^n is left; joined, H/2 each."""
    p = two_layer.Gains(transfer_s=0.1)
    beta, one = TICK_S / (TICK_S + 0.1), two_layer.Tank(level_j=0.2)
    for _ in range(50):
        one = two_layer.shared(one, TICK_S, p)
    assert one.level_j == pytest.approx(0.2 * (1.0 - beta) ** 50)
    assert one.level_j + one.sent_j == pytest.approx(0.2)
    tanks = [one._replace(sent_j=0.0), two_layer.Tank()]
    tanks = [two_layer.filled(tank, 0.0) for tank in tanks]
    for _ in range(2000):
        tanks = [two_layer.shared(tank, TICK_S, p) for tank in tanks]
        sums = [tank.sent_j for tank in tanks]
        tanks = [two_layer.filled(tank, sums[1 - i]) for i, tank in enumerate(tanks)]
    assert [tank.level_j for tank in tanks] == pytest.approx([0.5 * one.level_j] * 2, rel=1e-3)


def test_the_tank_level_controller_fills_the_tank_as_its_equation_says():
    """In free space at a speed v, dH/dt = alpha (H_d - H) v^2 without transfer and local damping:
    H = H_d (1 - exp(-alpha v^2 t)).
    """
    values = {"local": 0.0, "transfer_s": 1e6, "gain": 180.0, "level_j": 0.15}
    link = RivalLink(*made("two_layer", **values))
    link.go(-0.1 * 2.0, 250)
    expected = 0.15 * (1.0 - math.exp(-180.0 * 0.1**2 * 2.0))
    assert link.device.level_j == pytest.approx(expected, rel=0.01)
    assert link.work_j == pytest.approx(link.device.level_j, rel=0.01)


def bounded(stiffness_ratio, way_m):
    """Return forces wanted and rendered (less the damper) by energy bounding at every tick, with
    a spring of so many times kappa = 2 b/T.
    """
    record, p = made("energy_bounding", damping=0.5, reserve_j=0.0)
    kappa, link = 2.0 * p.damping / TICK_S, RivalLink(record, p)
    s, x, rows, force, xd = record.device_rest(p, 1), 0.0, [], 0.0, way_m / (50 * TICK_S)
    for _ in range(50):
        wanted = stiffness_ratio * kappa * x
        packet = link.nothing._replace(number=1, wave=(wanted,))
        tick = energy.DeviceTick((x,), (xd,), packet, False, False, (force,), TICK_S)
        s, answer = record.device(s, tick, p)
        (force,) = answer.force
        rows.append((wanted, force - p.damping * xd))
        x += xd * TICK_S
    return np.array(rows).T, kappa * way_m / 50


def test_energy_bounding_lets_springs_up_to_two_dampings_per_tick_pass_and_bounds_stiffer_ones():
    (wanted, given), _ = bounded(1.0, 5e-3)
    assert given == pytest.approx(wanted, abs=1e-9)
    (wanted, given), step = bounded(1.5, 5e-3)
    assert np.diff(given) == pytest.approx(step, rel=1e-6)  # |F| = |F_- + kappa dx|
    assert given[-1] < 0.7 * wanted[-1]


def test_the_model_is_the_least_squares_stiffness_and_changes_without_a_step_of_force():
    """Pressed at rest with an empty tank, a stiffer model is not paid and not rendered."""
    m = model_mediated.Model(300.0, 0.0, (0.0,), 1.0)
    aim = m._replace(stiffness=600.0)
    x, share = (5e-3,), TICK_S / (TICK_S + 0.01)
    kept = model_mediated.followed(m, aim, x, share, 0.0)
    assert kept == m
    paid = model_mediated.followed(m, aim, x, share, 1.0)
    assert paid.stiffness == pytest.approx(300.0 + share * 300.0)
    softer = model_mediated.followed(aim, m, x, share, 0.0)
    assert softer.stiffness == pytest.approx(600.0 - share * 300.0)
    free = model_mediated.followed(m, aim, (-5e-3,), share, 0.0)
    assert free == aim
    link = RivalLink(*made("model_mediated"), late=lambda n: 2)
    link.go(-0.01, 30)
    link.go(0.015, 100)
    link.go(0.0, 200)
    assert link.avatar.fe / link.avatar.ee == pytest.approx(series(K, 2000.0), rel=0.01)


def test_input_to_state_stable_adds_a_damping_tau_times_the_slope():
    """In contact at an even speed v, behind the first packets: F = f + tau mu v, mu the slope that
    the device sees, with local damping of zero.
    """
    forces = {}
    for tau_s in (0.0, 0.03):
        link = RivalLink(*made("iss_damping", tau_s=tau_s, local=0.0), damping=0.0)
        link.go(4e-3, 50)
        forces[tau_s] = link.force
    mu, v = series(K, 850.0), 4e-3 / (50 * FRAME_S)
    assert forces[0.03] - forces[0.0] == pytest.approx(0.03 * mu * v, rel=0.02)


def test_four_channels_without_a_controller_approach_the_wall_itself_as_force_is_fed_forward():
    felt = []
    for forward in (0.0, 0.5, 0.9):
        link = RivalLink(*made("four_channel_tdpa", forward=forward))
        link.go(4e-3, 100)
        link.go(0.0, 200)
        felt.append(link.force / link.x)
        assert felt[-1] == pytest.approx(series(K, 500.0 / (1.0 - forward)), rel=0.02)
    assert felt == sorted(felt)


def test_only_what_leaves_the_weber_deadband_is_updated():
    sent, kept = deadband_tdpa.Update(), []
    for value in (1.0, 1.05, 1.099, 1.11, 1.0, 0.99, 0.002, 0.004):
        sent = deadband_tdpa.updated(sent, (value,), (value,), 0.1, 5e-3)
        kept.append((sent.signal[0], sent.x[0]))
    assert kept == [
        *[(1.0, 1.0)] * 3, *[(1.11, 1.11)] * 2, (0.99, 0.99), *[(0.0, 0.002)] * 2
    ]  # fmt: skip
    link = RivalLink(*made("deadband_tdpa"), damping=0.0)
    link.go(4e-3, 200)
    assert abs(link.answer[0][0] - 4e-3 / (200 * FRAME_S)) < 1e-12
