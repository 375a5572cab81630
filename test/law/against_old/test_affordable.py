# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What energy covers is what it covered before the laws were written as functions."""

import numpy as np
import pytest
from support.laws import assert_same, old_form

from pmwvc_core.law.channel.affordable import affordable, repayment
from pmwvc_core.wave import affordable as old


@pytest.mark.parametrize("axes", [1, 3])
def test_same_changes_and_repayments(axes: int) -> None:
    rng = np.random.default_rng(axes)
    for _ in range(3000):
        wave = tuple((rng.normal(size=axes) * rng.choice([0.0, 0.1, 1.0])).tolist())
        change = tuple((rng.normal(size=axes) * rng.choice([0.0, 0.1, 1.0])).tolist())
        power = float(rng.normal() * rng.choice([0.0, 0.1, 1.0]))
        assert_same(
            affordable(wave, change, power),
            old.affordable(old_form(wave), old_form(change), power),
        )
        assert_same(
            repayment(change, wave, power), old.repayment(old_form(change), old_form(wave), power)
        )
