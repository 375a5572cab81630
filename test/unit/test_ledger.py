# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Running sums of energy."""

import numpy as np
import pytest

from pmwvc_core.wave.ledger import EnergyLedger, PortLedger
from pmwvc_core.wave.transform import WavePort


def test_a_wave_of_one_root_watt_carries_half_a_watt():
    ledger = EnergyLedger()
    for _ in range(1000):
        ledger.add(1.0, 0.001)
    assert ledger.energy_j == pytest.approx(0.5)


def test_a_force_that_moves_does_work_and_one_that_yields_gives_it_back():
    ledger = PortLedger()
    ledger.add(2.0, 0.5, 0.1)
    assert ledger.energy_j == pytest.approx(0.1)
    ledger.add(2.0, -0.5, 0.1)
    assert ledger.energy_j == 0.0


def test_the_work_at_a_port_is_the_difference_of_its_waves():
    rng = np.random.default_rng(8)
    port, out, back = PortLedger(), EnergyLedger(), EnergyLedger()
    for xd, v in rng.normal(size=(100, 2)).tolist():
        u = WavePort(25.0).u(xd, v)
        f = 25.0 * xd - 50.0**0.5 * v
        port.add(f, xd, 0.001)
        out.add(u, 0.001)
        back.add(v, 0.001)
        assert f * xd == pytest.approx((u**2 - v**2) / 2)
    assert port.energy_j == pytest.approx(out.energy_j - back.energy_j)


def test_every_run_has_its_own_sum_over_its_axes():
    waves = np.random.default_rng(9).normal(size=(50, 4, 3))
    together = EnergyLedger()
    for wave in waves:
        together.add(wave, 0.001)
    assert together.energy_j.shape == (4, 1)
    for run in range(4):
        single = [EnergyLedger() for _ in range(3)]
        for wave in waves:
            for axis in range(3):
                single[axis].add(float(wave[run, axis]), 0.001)
        total = sum(ledger.energy_j for ledger in single)
        assert together.energy_j[run, 0] == pytest.approx(total, rel=1e-12)


def test_an_hour_of_ticks_is_counted_to_nine_digits():
    ledger = EnergyLedger()
    for _ in range(3_600_000 // 10):  # a tenth of the ticks: the error grows at most linearly
        ledger.add(0.3, 0.001)
    assert ledger.energy_j == pytest.approx(0.045 * 360.0, rel=1e-10)
