# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Rivals of the benchmark: what they render, carry and release, and the equations of their papers.

Energies are counted from forces and ways at both ports (:mod:`support.rival_link`).
"""

import dataclasses
import json
import math
import os
import subprocess
import sys

import numpy as np
import pytest
from benchmark.rivals import (
    deadband_tdpa,
    energy,
    energy_bounding,
    four_channel,
    iss_damping,
    model_mediated,
    two_layer,
)
from support.command_line import ROOT
from support.rival_link import FRAME_S, TICK_S, M, RivalLink

RECORDS = {
    record.name: (record, module)
    for record, module in (
        (two_layer.TWO_LAYER, two_layer),
        (model_mediated.MODEL_MEDIATED, model_mediated),
        (iss_damping.ISS_DAMPING, iss_damping),
        (energy_bounding.ENERGY_BOUNDING, energy_bounding),
        (four_channel.FOUR_CHANNEL_TDPA, four_channel),
        (deadband_tdpa.DEADBAND_TDPA, deadband_tdpa),
    )
}
ROUNDING_J = 1e-9
K = 500.0  # [N/m] of the contact
NO_LIMIT = {"damping_max": 1e12}  # of the damper of a passivity controller
# What a rival claims: that the sum over both ports, or that the device alone with what the avatar
# has taken in, is never below zero.
BARE = NO_LIMIT | {"local": 0.0}
LINK = {
    "two_layer": {"local": 0.0},
    "four_channel_tdpa": BARE | {"stiffness": 1000.0, "damping": 1.0},
    "deadband_tdpa": BARE,
}
DEVICE = {"model_mediated": {}, "energy_bounding": {}}


def made(name, **values):
    record, _ = RECORDS[name]
    return record, record.params(**values)


def series(*stiffnesses):
    return 1.0 / sum(1.0 / each for each in stiffnesses)


@pytest.mark.parametrize(
    ("name", "rendered", "within"),
    [
        ("two_layer", series(K, 1000.0), 0.01),
        ("model_mediated", series(K, 2000.0), 0.01),
        ("iss_damping", series(K, 850.0), 0.01),
        ("energy_bounding", series(K, 800.0), 0.01),
        ("four_channel_tdpa", series(K, 500.0 / (1.0 - 0.5)), 0.01),
        ("deadband_tdpa", K, 0.1),  # its deadband, and energy that comes a frame late
    ],
)
def test_without_delay_a_wall_is_felt_as_its_spring_in_series_with_that_of_the_avatar(
    name, rendered, within
):
    link = RivalLink(*made(name))
    for _ in range(4):  # to and fro in free space: what tanks need
        link.go(-0.02, 20)
        link.go(0.02, 20)
    link.go(0.004, 100)
    link.go(0.0, 100)
    assert link.force / link.x == pytest.approx(rendered, rel=within)
    link.go(-0.008, 50)
    link.go(0.0, 20)
    assert abs(link.force) < 0.01  # outside nothing is left
    assert link.x_s == pytest.approx(link.x, abs=5e-4)


def swing(name, seed, **values):
    """Return the least of both claims over two seconds: the device swings in and out of a wall
    that moves, packets are late by up to 8 frames, and 0 to 60 % are lost.
    """
    rng = np.random.default_rng(seed)
    loss, longest = rng.uniform(0.0, 0.6), int(rng.integers(1, 9))

    def late(n):
        return int(rng.integers(0, longest + 1)) if rng.random() >= loss else None

    link = RivalLink(*made(name, **values), late=late, grip=bool(seed % 2))
    hz, phase, size = rng.uniform(0.5, 4.0), rng.uniform(0.0, 6.0), rng.uniform(2e-3, 1e-2)
    least = [0.0, 0.0]
    shake, before = 0.0, size * math.sin(phase)
    for n in range(250):
        row = []
        for tick in range(n * M, n * M + M):
            t = (tick + 1) * TICK_S
            shake = 0.99 * shake + rng.normal(0.0, 1e-5)
            at = size * math.sin(2.0 * math.pi * hz * t + phase) + shake
            row.append((at - before) / TICK_S)
            before = at
        link.frame(row, wall=2e-3 * math.sin(2.0 * math.pi * 0.7 * n * FRAME_S))
        of_device = link.work_j + link.taken_j
        least = [min(least[0], link.balance_j), min(least[1], of_device)]
    return least


def unlimited(monkeypatch, module):
    """Have both ends believe that the other has sent them any energy."""

    def gift(s, sum_j):
        return energy.Received(sum_j, True), 1e6

    monkeypatch.setattr(energy, "received", gift)
    if hasattr(module, "received"):
        monkeypatch.setattr(module, "received", gift)


@pytest.mark.parametrize("name", [*LINK, *DEVICE])
def test_what_a_rival_claims_never_to_release_it_does_not(name):
    claim, values = (0, LINK[name]) if name in LINK else (1, DEVICE[name])
    worst = min(swing(name, seed, **values)[claim] for seed in range(16))
    assert worst >= -ROUNDING_J


@pytest.mark.parametrize("name", [*LINK, *DEVICE])
def test_control_with_energy_that_nobody_sent_the_same_swings_release_some(name, monkeypatch):
    _, module = RECORDS[name]
    unlimited(monkeypatch, module)
    claim, values = (0, LINK[name]) if name in LINK else (1, DEVICE[name])
    if name == "model_mediated":
        values = {"cap_j": 1e6}
    assert min(swing(name, seed, **values)[claim] for seed in range(6)) < -1e-4


def test_the_input_to_state_stable_one_is_not_passive_as_it_says():
    assert min(swing("iss_damping", seed)[0] for seed in range(6)) < -1e-4


def carried(script):
    """Run Python where the rivals are installed; return what it prints, as JSON."""
    path = os.pathsep.join(
        [
            os.environ.get("PYTHONPATH", ""),
            *(str(ROOT / "tools" / e) for e in ("", "benchmark/rivals")),
        ]
    )
    run = subprocess.run(
        [sys.executable, "-c", script],
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    return json.loads(run.stdout)


CARRY = """
import json
import numpy as np
from benchmark.methods import METHODS
from benchmark.rivals import RIVALS
from benchmark.trial import Trial, run
from pmwvc_core.simulation.session import simulate_one

found = {}
for name in RIVALS:
    of = METHODS[name]
    texts = {}
    for settings in of.candidates(3, 1):
        scenario = Trial(name, settings, "carry", "thesis_lan_16", 1, 1.0).scenario
        texts[settings] = [str(user.operator) + str(user.link_up) for user in scenario.users]
    one = run(Trial(name, of.settings, "carry", "thesis_lan_16", 1, 6.0))
    deep = simulate_one(Trial(name, (*of.settings, "dof=3"), "carry", "wifi_bad", 1, 1.5).scenario)
    found[name] = {
        "failure": one.failure, "path_m": one.path_error_m, "lost": one.grip_lost,
        "hands": len(set(map(str, texts.values()))), "ranges": len(of.ranges),
        "finite": bool(np.isfinite([user.f_applied for user in deep.users]).all()),
        "own": sorted(set(vars(getattr(scenario.users[0].own, name)))),
        "searched": sorted(each.partition(".")[2] for each, _, _ in of.ranges[:-1]),
    }
print(json.dumps(found))
"""


def test_every_rival_is_a_method_of_the_search_and_carries_the_cube_over_16_ms_with_defaults():
    found = carried(CARRY)
    assert sorted(found) == sorted(RECORDS)
    for name, one in found.items():
        assert one["failure"] == "", name
        assert one["path_m"] < 0.012, name  # of 50 mm
        assert one["lost"] < 0.05, name
        assert one["hands"] == 1, name
        assert one["finite"], name
        assert one["own"] == one["searched"], name


def test_defaults_lie_within_the_ranges_searched():
    for record, module in RECORDS.values():
        defaults = dataclasses.asdict(record.params())
        assert set(defaults) == set(module.RANGES)
        assert all(low < defaults[leaf] < high for leaf, (low, high) in module.RANGES.items())


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
