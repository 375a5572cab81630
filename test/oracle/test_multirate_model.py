# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The exact model says what the session simulator does: 500 ticks on random parameters."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from support import linear_loops

from pmwvc_analysis.models.linearize import build, spectral_radius

TICKS = 500
NUMBERS = {
    "master.impedance": (5.0, 60.0),
    "device.mass": (0.1, 0.6),
    "device.damping": (0.0, 3.0),
    "server.contact_stiffness": (0.0, 1500.0),
    "server.contact_damping": (0.0, 12.0),
    "baseline.virtual_coupling.stiffness": (20.0, 600.0),
    "baseline.virtual_coupling.damping": (0.1, 6.0),
}
FILTERS = (
    {"kind": "first_order", "pole_rad_s": 50.0},
    {"kind": "first_order", "cutoff_hz": 12.0},
    {"kind": "butterworth", "pass_hz": 25.0, "stop_hz": 50.0},
    {"kind": "butterworth", "pass_hz": 20.0, "stop_hz": 70.0},
    {"kind": "integrate_and_dump"},
    {"kind": "none"},
)


EXACT = {"velocity_filter.kind": "exact", "velocity_filter.cutoff_hz": 20.0}
AROUND = (
    {},
    EXACT,
    {"velocity_filter.kind": "exact", "velocity_filter.order": 1, "velocity_filter.alpha": 0.93},
    {"velocity_filter.kind": "equivalent", "velocity_filter.cutoff_hz": 90.0},
    {"velocity_filter.kind": "complementary", "velocity_filter.cutoff_hz": 40.0},
    {"bank.kind": "dissertation", "local_model.damping": 4.0},
    {"bank.kind": "complementary", "bank.split_rad_s": 80.0, "local_model.stiffness": 900.0},
    {"bank.kind": "complementary", "velocity_filter.share": 0.3} | EXACT,
)


@st.composite
def scenarios(draw, delays_s=(0.0, 0.001, 0.0035, 0.008, 0.021)):
    users = draw(st.integers(1, 4))
    values = {
        "users": users,
        "controller": draw(st.sampled_from([*["pmwvc"] * 5, "direct", "virtual_coupling"])),
        "master.rate_drop": draw(st.sampled_from([1, 2, 5, 8, 12])),
        "master.hold": draw(st.sampled_from(["zoh", "foh"])),
        "device.velocity": draw(st.sampled_from(["exact", "euler"])),
        "server.period_s": draw(st.sampled_from([0.001, 0.002, 0.008, 0.012])),
        "server.coupling": draw(
            st.sampled_from(["implicit", "one_step_delay", "one_frame_late", "unwrapped"])
        ),
        "server.integrator": draw(
            st.sampled_from(["forward_euler", "backward_euler", "trapezoid"])
        ),
        "server.environment": draw(st.sampled_from(["cube", "cube", "wall"])),
        "server.object_mass": draw(st.floats(0.5, 3.0)),
        "server.object_damping": draw(st.sampled_from([0.0, 0.0, 2.0])),
    }
    kind = draw(st.sampled_from(FILTERS))
    for name, value in ({"pole_rad_s": None} | kind).items():
        values[f"master.filter.{name}"] = value
    values |= {f"master.{name}": value for name, value in draw(st.sampled_from(AROUND)).items()}
    if draw(st.integers(0, 3)) == 0:
        values |= {"master.position.feedback": "printed", "master.position.gain": 15.0}
    if values["controller"] == "pmwvc" and draw(st.integers(0, 3)) == 0:
        values |= {"server.coupling": "unknown", "server.compensation": "none"}
        values["server.decoding"] = "late"
        values["server.environment"] = draw(st.sampled_from(["cube", "wall", "wall_with_slope"]))
    if draw(st.booleans()):
        values["server.impedance"] = draw(st.floats(5.0, 60.0))
    if draw(st.booleans()):
        values["user1.master.rate_drop"] = draw(st.sampled_from([3, 4, 10]))
    for user in range(1, users + 1):
        for name, (low, high) in NUMBERS.items():
            values[f"user{user}.{name}"] = draw(st.floats(low, high))
        for way in ("up", "down"):
            delay_s = draw(st.sampled_from(delays_s))
            values[f"user{user}.link.{way}.delay_s"] = delay_s
    return linear_loops.scenario(**{n.replace(".", "__"): v for n, v in values.items()})


def bounded(model):
    """Tell whether numbers stay in range: a black box takes no force beyond 1e6 N."""
    return np.log10(spectral_radius(model) + 1e-300) * TICKS / model.ticks < 6.0


def compare(scenario, *, model=None, live=False, before=lambda batch: None):
    """Return the largest difference between model and simulator, relative to the signal;
    ``before`` is called with the session before it runs.
    """
    model = model or build(scenario, live=live)
    rng = np.random.default_rng(5)
    given_forces = rng.normal(size=(len(model.scenario.users), TICKS))
    traces = linear_loops.simulated(scenario, given_forces, live=live, before=before)
    # Before, all is at rest. Hands begin when they meet an answer: what they did is recorded.
    skip = linear_loops.SETTLED // model.ticks * model.ticks
    forces = np.stack([trace.f_h[skip:, 0] for trace in traces.users])
    found = linear_loops.modelled(model, forces)
    worst = 0.0
    for name, signal in (("x", "x_m"), ("xd", "xd_m"), ("f", "f_m")):
        for user, trace in enumerate(traces.users):
            seen = getattr(trace, signal)[:, 0]
            seen = seen[skip:] - (seen[0] if name == "x" else 0.0)
            floor = 1e-3 if name == "f" else 1e-12  # hands push with 1 N: less is rounding
            scale = max(np.abs(seen).max(), np.abs(found[name][user]).max(), floor)
            worst = max(worst, np.abs(seen - found[name][user]).max() / scale)
    return worst


as_live = scenarios(delays_s=(0.001, 0.003, 0.0082, 0.02))


@settings(max_examples=12, deadline=None)
@given(st.one_of(*[st.tuples(scenarios(), st.just(False))] * 2, st.tuples(as_live, st.just(True))))
def test_model_and_simulator_agree_on_random_parameters(drawn):
    """A third of them with the phases of live loops."""
    scenario, live = drawn
    model = build(scenario, live=live)
    assume(bounded(model))
    assert compare(scenario, model=model, live=live) < 1e-9


@pytest.mark.parametrize(("frame", "period_s"), [(8, 0.002), (12, 0.003)])
def test_position_feedback_counts_where_the_server_steps_within_a_frame(frame, period_s):
    fed = {"master__position__feedback": "printed", "link__down__delay_s": 0.001}
    fed |= {"master__rate_drop": frame, "server__period_s": period_s}
    scenario = linear_loops.scenario(**fed, master__position__gain=15.0)
    assert compare(scenario) < 1e-9
    without = build(linear_loops.scenario(**fed, master__position__gain=0.0))
    assert compare(scenario, model=without) > 1e-3  # the control


def test_the_phases_of_live_loops_matter():
    scenario = linear_loops.scenario(link__delay_s=0.008)
    assert compare(scenario, model=build(scenario, live=True)) > 1e-3


def test_a_model_of_other_parameters_does_not_agree():
    scenario = linear_loops.scenario(link__delay_s=0.008)
    other = build(linear_loops.scenario(link__delay_s=0.008, device__mass=0.2501))
    assert compare(scenario) < 1e-9
    assert compare(scenario, model=other) > 1e-6
