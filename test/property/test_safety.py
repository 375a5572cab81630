# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The force stays within its limits under any controller, device and network."""

import math
from types import SimpleNamespace

import numpy as np
from hypothesis import event, given
from hypothesis import strategies as st

from pmwvc_core.master.safety.limiter import SafetyLimiter
from pmwvc_core.master.safety.states import SafetyState
from pmwvc_core.params import SafetyParams

TICK_S = 0.001
wild = st.one_of(
    st.floats(-20.0, 20.0),
    st.floats(allow_nan=True, allow_infinity=True),
    st.sampled_from([math.nan, math.inf, -math.inf, 0.0, 1e308, -1e308, 5e-324, 1e-160]),
)
limits = st.fixed_dictionaries(
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
        f, x, xd = form(part.f), form(part.x), form(np.asarray(part.xd))
        for _ in range(part.ticks):
            after = safety.step(f, x, xd, silence_s=part.silence_s, coupled=part.coupled)
            yield part, before, after
            before = after


def limiter(params):
    return SafetyLimiter(SafetyParams(**params), tick_s=TICK_S, packet_s=0.008)


def as_float(vector):
    return float(vector[0])


@given(limits, stretches(1))
def test_a_force_on_one_axis_keeps_size_and_slew(params, story):
    safety = limiter(params)
    for part, before, after in play(safety, story, as_float):
        assert abs(after - before) <= params["max_slew"] * TICK_S * (1 + 1e-12) + 1e-15
        assert abs(after) <= params["max_force"] * (1 + 1e-12)
        assert safety.state != SafetyState.COUPLED or part.coupled


@given(limits, stretches(3))
def test_a_force_vector_keeps_length_and_slew(params, story):
    for _, before, after in play(limiter(params), story, np.array):
        change = np.linalg.norm(after - before)
        assert change <= params["max_slew"] * TICK_S * (1 + 1e-12) + 1e-15
        assert np.linalg.norm(after) <= params["max_force"] * (1 + 1e-12)


class OnlySaturation:
    """What many rigs have: the force is clipped, nothing else."""

    def step(self, f, x, xd, *, silence_s, coupled):
        return max(-8.0, min(8.0, f))


def test_control_clipping_alone_makes_steps_and_full_force_of_no_number():
    def part(f):
        return SimpleNamespace(
            ticks=1, f=np.array([f]), x=[0.0], xd=[0.0], silence_s=0.0, coupled=True, rearm=False
        )

    story = [part(f) for f in (5.0, -math.inf, math.nan)]
    forces = [after for _, _, after in play(OnlySaturation(), story, as_float)]
    steps = np.abs(np.diff([0.0, *forces]))
    assert steps[1] > 2000.0 * TICK_S
    assert forces[-1] == 8.0


@given(limits, stretches(1))
def test_every_soft_start_begins_with_its_first_share_of_the_force(params, story):
    safety, rising = limiter(params), False
    share = TICK_S / params["soft_start_s"] * (1 + 1e-9)
    for part, before, after in play(safety, story, as_float):
        if safety.reason == "soft start" and not rising:
            assert abs(after) <= max(abs(before), share * abs(part.f[0])) * (1 + 1e-12)
        rising = safety.reason == "soft start"


@given(limits, stretches(1))
def test_in_a_fault_the_force_only_falls(params, story):
    safety, faulty = limiter(params), False
    for part, before, after in play(safety, story, as_float):
        if faulty and not part.rearm:
            assert safety.state == SafetyState.FAULT or not part.coupled
            assert abs(after) <= abs(before)
        faulty = safety.state == SafetyState.FAULT


@given(limits, st.floats(-20.0, 20.0), st.floats(-1.0, 1.0), st.floats(-20.0, 20.0))
def test_half_a_second_into_silence_nothing_pushes(params, f, xd, f_before):
    safety = limiter(params | {"timeout_s": 0.03, "release_s": 60.0, "max_slew": 2000.0})
    for _ in range(200):
        safety.step(f_before, 0.0, 0.0, silence_s=0.0, coupled=True)
    for _ in range(500):
        applied = safety.step(f, 0.0, xd, silence_s=0.2, coupled=True)
    assert applied * xd >= 0.0
    assert applied == 0.0 or f * xd > 0.0


@given(st.lists(limits, min_size=2, max_size=4), stretches(1), st.integers(0, 2**32 - 1))
def test_a_batch_is_its_runs_side_by_side(rows, story, seed):
    """Each run has other limits, other inputs and its own silence."""
    same = {name: rows[0][name] for name in ("timeout_s", "release_s")}
    rows = [row | same for row in rows]
    stacked = {name: np.array([[row[name]] for row in rows]) for name in rows[0]} | same
    batch, singles = limiter(stacked), [limiter(row) for row in rows]
    rng = np.random.default_rng(seed)
    for part in story:
        scale = rng.uniform(-2.0, 2.0, (len(rows), 1))
        with np.errstate(over="ignore"):
            f, xd = part.f * scale, np.asarray(part.xd) * scale
        silence_s = part.silence_s * (scale > 0.0) if part.silence_s < math.inf else scale * 0.0
        together, alone = [], []
        for _ in range(part.ticks):
            stepped = batch.step(f, np.ones_like(f), xd, silence_s=silence_s, coupled=part.coupled)
            together.append(np.broadcast_to(np.ravel(stepped), len(rows)))
            alone += [
                single.step(
                    float(f[run, 0]),
                    1.0,
                    float(xd[run, 0]),
                    silence_s=float(silence_s[run, 0]),
                    coupled=part.coupled,
                )
                for run, single in enumerate(singles)
            ]
        np.testing.assert_allclose(np.ravel(together), alone, rtol=1e-12, atol=1e-15)
        states = np.broadcast_to(np.ravel(batch.state), len(rows))
        np.testing.assert_array_equal(states, [single.state for single in singles])
        events = np.broadcast_to(np.ravel(batch.events), len(rows))
        np.testing.assert_array_equal(events, [single.events for single in singles])
        reasons = batch.reason if isinstance(batch.reason, list) else [batch.reason] * len(rows)
        assert reasons == [single.reason for single in singles]


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


@given(limits, mostly_calm)
def test_an_inactive_tick_equals_the_tick_computed_in_full(params, story):
    """Forces, states and events are the same bits as without the glance."""
    glancing, working = limiter(params), limiter(params)
    glances = 0
    for what, share, ticks in story:
        f = (
            share
            * params["max_force"]
            * {"limit": 3.0, "edge": 1.0 / (abs(share) or 1.0)}.get(what, 0.9)
        )
        f = math.nan if what == "nan" else f
        xd = params["damper_velocity"] * (1.5 if what == "fast" else 0.3) * share
        silence_s = 2.0 if what == "silent" else 0.0
        for _ in range(ticks):
            working.inactive = False
            both = [
                safety.step(f, 0.0, xd, silence_s=silence_s, coupled=what != "away")
                for safety in (glancing, working)
            ]
            assert both[0] == both[1]
            assert (glancing.state, glancing.reason) == (working.state, working.reason)
            assert (glancing.events, glancing.ready) == (working.events, working.ready)
            assert glancing._fading.gain == working._fading.gain
            glances += glancing.inactive
    event(f"calm ticks: {min(glances, 100) // 10 * 10}+")
