# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Compiled, what energy covers is what it is as it stands."""

import numpy as np
import pytest
from support.laws import assert_same, in_bulk

from pmwvc_core.law.wave.wave import affordable, repayment


def covered(wave, change, power):
    return affordable(wave, change, power), repayment(change, wave, power)


@pytest.mark.parametrize("axes", [1, 3])
def test_what_energy_covers(axes: int) -> None:
    rng, bulk = np.random.default_rng(axes), in_bulk(covered)
    for _ in range(300):
        wave, change = (
            tuple((rng.normal(size=axes) * rng.choice([0.0, 0.1, 1.0])).tolist()) for _ in "wc"
        )
        power = float(rng.normal() * rng.choice([0.0, 0.1, 1.0]))
        assert_same(bulk(wave, change, power), covered(wave, change, power))
