# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The playout as pure functions does what the class does."""

import math
import random

import numpy as np
import pytest

from pmwvc_core.law.channel import playout as law
from pmwvc_core.wave.playout import Playout

H = 0.001


def value(vector):
    return vector[0] if len(vector) == 1 else np.array(vector)


def same(got, wanted, scale=1.0):
    assert np.allclose(np.ravel(got), np.ravel(wanted), rtol=1e-12, atol=1e-12 * scale)


@pytest.mark.parametrize("axes", [1, 3])
@pytest.mark.parametrize("seed", range(6))
def test_every_step_of_both_is_the_same(axes, seed):
    luck = random.Random(seed)
    params = law.PlayoutParams(
        0.06 * math.sqrt(12.5), luck.choice([0.1, 0.2]), luck.choice([0.0, 1e-3])
    )
    old = Playout(most_repaid=params.most_repaid, rises_s=params.rises_s, store_j=params.store_j)
    nothing = (0.0,) * axes
    s = law.resting_playout(nothing, law.Moved(0.0, 0.0, 0.0, 0.0, 0.0))
    held, wave = [], [0.0] * axes
    seen = set()
    for tick in range(4000):
        if tick % 8 == 0:
            wave = [w + luck.gauss(0.0, 0.3) for w in wave]
            wave = [0.97 * w for w in wave]
            dt = 0.008 * luck.choice([1, 1, 1, 1, 2])
            held.append((tuple(w * dt for w in wave), dt))
        outage = tick % 2000 in range(600, 600 + 40 * (seed % 6))
        if held and not outage and luck.random() < (0.08 if seed % 3 else 0.5):
            together = luck.choice([1, 1, 2]) if len(held) > 1 else 1
            for integral, dt in held[: together if seed % 2 else len(held)]:
                paid = luck.choice([0.3, 1.0, 1.0, 1.2]) * sum(u * u for u in integral) / (2 * dt)
                old.add(value(integral), paid, dt)
                s = law.add(s, integral, paid, dt)
            del held[: together if seed % 2 else len(held)]
        chance = luck.random()
        if chance < 0.002:
            old.pass_by(0.05), seen.add("pass_by")
            s = law.pass_by(s, 0.05)
        elif chance < 0.0025:
            old.begin()
            s = law.begin(s)
        given = old.step(H)
        s, got = law.play(s, H, params)
        same(got, given)
        if chance > 0.99:
            back = tuple(0.5 * g for g in got)
            old.take_back(value(back), H)
            s = law.take_back(s, back, H)
        elif chance > 0.97:
            s, released = law.spared(s, H, True)
            same(released, old.spared(H, wanted=True))
        elif chance > 0.95:
            s, released = law.release(s, 1e-3, 1e-3)
            same(released, old.release(1e-3, beyond=1e-3))
        same(s.undelivered, old.undelivered)
        same(law.free_j(s), old.free_j)
        same(law.waiting(s), old.waiting)
        assert law.is_short(s) == bool(old.short)
        if s.pace.silent_s > 0.04:
            seen.add("brakes")
        if law.is_short(s):
            seen.add("short")
        if s.moved.lent_j > 0:
            seen.add("lent")
    for name in ("received_j", "given_j", "released_j", "discarded_j"):
        same(getattr(s.moved, name), getattr(old, name))
    print(seed, axes, seen)
