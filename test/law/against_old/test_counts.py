# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Counts and anti-aliasing filters as pure functions do what the classes do."""

import random

import numpy as np
import pytest

from pmwvc_core.law.port.counts import counts, may_count, resting_counts, rough_count
from pmwvc_core.law.vectors import columns, each
from pmwvc_core.law.wave.anti_aliasing import (
    filter_params,
    filter_sample,
    filter_step,
    resting_filter,
)
from pmwvc_core.master.counts import BetweenCounts
from pmwvc_core.params import FilterParams
from pmwvc_core.wave.rates import AntiAliasing


def value(vector):
    return vector[0] if len(vector) == 1 else np.array(vector)


def same(got, wanted):
    assert np.allclose(np.ravel(got), np.ravel(wanted), rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("axes", [1, 3])
@pytest.mark.parametrize("seed", range(6))
def test_counts_of_both_are_the_same(axes, seed):
    luck = random.Random(seed)
    step = luck.choice([0.0, 1e-9, 2e-5, 1e-4])
    own = seed % 3 == 0
    x, xd = [0.01 * a for a in range(axes)], [0.0] * axes
    old, s = BetweenCounts(0.001), None
    for tick in range(3000):
        if tick % 700 > 300:
            xd = [0.99 * v + luck.gauss(0.0, 0.01) for v in xd]
            x = [a + 0.001 * v for a, v in zip(x, xd, strict=True)]
        read = tuple(step * round(a / step) if step else a for a in x)
        if s is None:
            last = read
            s = tuple(map(resting_counts, read))
            old.begin(value(read))
        v = tuple(xd) if own else tuple((a - b) / 0.001 for a, b in zip(read, last, strict=True))
        last = read
        s, out = columns(each(counts, (s, read, v), 0.001))
        same([o.xd for o in out], old.step(value(read), value(v)))
        same([o.dx for o in out], old.dx)
        same([o.moved for o in out], old.moved)
        same([rough_count(a) for a in s], old.rough + 0.0 * value(read))
        if axes == 1:
            assert may_count(s[0]) == old.counts


FILTERS = {
    "none": {},
    "first_order": {"pole_rad_s": 300.0},
    "butterworth": {"stop_hz": 60.0},
    "integrate_and_dump": {},
}


@pytest.mark.parametrize("axes", [1, 3])
@pytest.mark.parametrize("kind", FILTERS)
def test_filters_of_both_are_the_same(axes, kind):
    luck = random.Random(1)
    params = FilterParams(kind=kind, **FILTERS[kind])
    old = AntiAliasing(params, tick_s=0.001, rate_drop=8)
    p = filter_params(params, tick_s=0.001, rate_drop=8)
    s = resting_filter(params, axes, p)
    for tick in range(500):
        u = tuple(luck.gauss(0.0, 1.0) for _ in range(axes))
        s, y = filter_step(s, u, p)
        same(y, old.step(value(u)))
        if tick % luck.choice([7, 8, 9]) == 0:
            s, y = filter_sample(s, p)
            same(y, old.sample())
