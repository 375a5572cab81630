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
    energy,
)
from support.command_line import ROOT
from support.rival_link import FRAME_S, RECORDS, TICK_S, K, M, RivalLink, made, series

ROUNDING_J = 1e-9
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
    worst = min(swing(name, seed, **values)[claim] for seed in range(12))
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
    one = run(Trial(name, of.settings, "carry", "thesis_lan_16", 1, 4.5))
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
