# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The force stays within its limits under any controller, device and network."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import event, given
from hypothesis import strategies as st
from support.law_rigs import ForceLimits

from pmwvc_core.master.safety import SafetyState

TICK_S = 0.001
wild = st.one_of(
    st.floats(-20.0, 20.0),
    st.floats(allow_nan=True, allow_infinity=True),
    st.sampled_from([math.nan, math.inf, -math.inf, 0.0, 1e308, -1e308, 5e-324, 1e-160]),
)
bounds = st.fixed_dictionaries(
    {
        "max_force": st.floats(0.01, 20.0),
        "max_slew": st.floats(1.0, 20000.0),
        "soft_start_s": st.floats(0.01, 0.1),
        "damper_velocity": st.floats(0.01, 1.0),
        "fault_velocity": st.floats(1.01, 20.0),
        "timeout_s": st.floats(0.001, 0.1),
        "release_s": st.floats(0.1, 1.0),
    }
)


def stretches(dof):
    """Draw stretches of ticks with constant, arbitrary input; now and then a restart."""
    values = st.lists(wild, min_size=dof, max_size=dof).map(np.array)
    return st.lists(
        st.builds(
            SimpleNamespace,
            ticks=st.integers(1, 25),
            f=values,
            x=values,
            xd=st.one_of(values, st.lists(st.floats(-1.0, 1.0), min_size=dof, max_size=dof)),
            silence_s=st.one_of(st.just(0.0), st.floats(0.0, 3.0), st.just(math.inf)),
            coupled=st.one_of(st.just(True), st.booleans()),
            rearm=st.booleans(),
            other_server=st.booleans(),
        ),
        min_size=1,
        max_size=8,
    )


def play(safety, story, form):
    """Yield (stretch, force before, force) for every tick."""
    before = form(np.zeros(len(story[0].f)))
    for part in story:
        if part.rearm:
            safety.rearm()
        if part.other_server:
            safety.restart()
        f, x, xd = form(part.f), form(part.x), form(np.asarray(part.xd))
        for _ in range(part.ticks):
            after = safety(f, xd, x=x, silence_s=part.silence_s, coupled=part.coupled)
            yield part, before, after
            before = after


def as_float(vector):
    return float(vector[0])


@pytest.mark.parametrize("dof", [1, 3])
@given(params=bounds, data=st.data())
def test_a_force_keeps_length_and_slew(dof, params, data):
    safety, form = ForceLimits(axes=dof, **params), as_float if dof == 1 else np.array
    for part, before, after in play(safety, data.draw(stretches(dof)), form):
        change = np.linalg.norm(after - before)
        assert change <= params["max_slew"] * TICK_S * (1 + 1e-12) + 1e-15
        assert np.linalg.norm(after) <= params["max_force"] * (1 + 1e-12)
        assert safety.state != SafetyState.COUPLED or part.coupled


class OnlySaturation:
    """What many rigs have: the force is clipped, nothing else."""

    def __call__(self, f, xd, *, x, silence_s, coupled):
        return max(-8.0, min(8.0, f))


def test_control_clipping_alone_makes_steps_and_full_force_of_no_number():
    def part(f):
        return SimpleNamespace(
            ticks=1,
            f=np.array([f]),
            x=[0.0],
            xd=[0.0],
            silence_s=0.0,
            coupled=True,
            rearm=False,
            other_server=False,
        )

    story = [part(f) for f in (5.0, -math.inf, math.nan)]
    forces = [after for _, _, after in play(OnlySaturation(), story, as_float)]
    steps = np.abs(np.diff([0.0, *forces]))
    assert steps[1] > 2000.0 * TICK_S
    assert forces[-1] == 8.0


@given(bounds, stretches(1))
def test_every_soft_start_begins_with_its_first_share_of_the_force(params, story):
    """One that a silence of the same server interrupts goes on from what had not faded."""
    safety, rising = ForceLimits(**params), False
    share = TICK_S / params["soft_start_s"] * (1 + 1e-9)
    for part, before, after in play(safety, story, as_float):
        if safety.reason == "soft start" and not rising:
            assert abs(after) <= max(abs(before), share * abs(part.f[0])) * (1 + 1e-12)
        rising = safety.reason == "soft start" or (rising and part.silence_s > 0.0)


@given(bounds, stretches(1))
def test_in_a_fault_the_force_only_falls(params, story):
    safety, faulty = ForceLimits(**params), False
    for part, before, after in play(safety, story, as_float):
        if faulty and not part.rearm:
            assert safety.state == SafetyState.FAULT or not part.coupled
            assert abs(after) <= abs(before)
        faulty = safety.state == SafetyState.FAULT


@given(bounds, st.floats(-20.0, 20.0), st.floats(-1.0, 1.0), st.floats(-20.0, 20.0))
def test_half_a_second_into_silence_nothing_pushes(params, f, xd, f_before):
    calm = {"timeout_s": 0.03, "release_s": 60.0, "max_slew": 2000.0}
    safety = ForceLimits(**params | calm)
    safety(f_before, ticks=200)
    applied = safety(f, xd, silence_s=0.2, ticks=500)
    assert applied * xd >= 0.0
    assert applied == 0.0 or f * xd > 0.0


mostly_calm = st.lists(
    st.tuples(
        st.sampled_from(
            ["keep", "keep", "keep", "limit", "edge", "fast", "nan", "silent", "away"]
        ),
        st.floats(-1.0, 1.0),
        st.integers(1, 30),
    ),
    min_size=1,
    max_size=12,
)


@given(bounds, mostly_calm)
def test_a_calm_tick_lets_the_force_through_bit_for_bit(params, story):
    safety, calm_ticks = ForceLimits(**params), 0
    for what, share, ticks in story:
        f, xd, silence_s = asked_for(what, share, params)
        for _ in range(ticks):
            before, was = safety.s.f[0], safety.reason
            applied = safety(f, xd, silence_s=silence_s, coupled=what != "away")
            calm = what == "keep" and was == "" and abs(f - before) <= safety.p.slew
            assert (applied == f and safety.reason == "") or not calm
            calm_ticks += calm
    event(f"calm ticks: {min(calm_ticks, 100) // 10 * 10}+")


def asked_for(what, share, params):
    """Return force, velocity and silence of a stretch."""
    wanted = {"limit": 3.0, "edge": 1.0 / (abs(share) or 1.0)}.get(what, 0.9)
    f = math.nan if what == "nan" else share * params["max_force"] * wanted
    xd = params["damper_velocity"] * (1.5 if what == "fast" else 0.3) * share
    return f, xd, 2.0 if what == "silent" else 0.0
