# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Who drives a motion, the loop or the hands, and what the verdict makes of it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.simulated import simulated

from pmwvc_analysis.verdicts.drive import UNKNOWN, drive, works
from pmwvc_analysis.verdicts.stability import verdict
from pmwvc_analysis.verdicts.verdicts import summary
from pmwvc_bringup import scenarios

DIRECT = ("controller=direct", "link.delay_s=0.016")
IDEAL = ("controller=direct", "link.delay_s=0")
PLAIN = ("channel=plain", "link.delay_s=0.016")
STRICT = ("channel=strict", "link.delay_s=0.016")


def wall(*texts, duration_s=8.0):
    """Return the scenario of one hand at a wall."""
    return scenarios.load("wall", settings_texts=texts, duration_s=duration_s)


def judged(scenario):
    """Return the verdict on stability of its session."""
    return verdict(simulated(scenario), scenario)


def drove(traces, scenario, start_s, end_s):
    """Return who drove its motion."""
    return drive(traces, scenario, start_s, end_s, works(traces, scenario))


def pressed(tmp_path, *, from_s, until_s):
    """Return the settings of a hand that presses on the wall for a time."""
    times = np.arange(0.0, 12.0, 0.01)
    closing, opening = (np.clip((times - at_s) / 0.5, 0.0, 1.0) for at_s in (from_s, until_s))
    target = 0.02 * (closing - opening)  # from 5 mm in front of it
    file = tmp_path / "target.csv"
    np.savetxt(file, np.c_[times, target], delimiter=",", header="t,x", comments="")
    of = "user1.operator."
    words = {"kind": "playback_motion", "file": file, "columns": "x", "time_column": "t"}
    wall = ("server.contact_stiffness=800", "server.contact_damping=2")
    return *wall, *(f"{of}{name}={value}" for name, value in words.items())


@pytest.mark.parametrize(("from_s", "until_s"), [(1.0, 4.0), (3.0, 8.0)])
def test_a_loop_that_shook_while_it_was_pressed_is_not_stable(tmp_path, from_s, until_s):
    hand = pressed(tmp_path, from_s=from_s, until_s=until_s)
    found = judged(wall(*DIRECT, *hand))
    assert found.stable is False, found.why
    if until_s < 8.0:  # else it still shakes at the end, which the limits show as well
        assert found.instability == "sustained oscillation"
        assert "the loop gave the hands" in found.why
    for kept in (PLAIN, IDEAL):
        assert judged(wall(*kept, *hand)).stable is True


def recorded(recorded_data, offset_m):
    """Return the settings of a recorded person who taps on the wall."""
    words = {
        "kind": "playback_motion",
        "file": recorded_data / "tue_hand.csv",
        "rate_hz": 2000,
        "scale": 0.075,
        "offset": offset_m,
        "repeat": "true",
    }
    return tuple(f"user1.operator.{name}={value}" for name, value in words.items())


@pytest.mark.parametrize("offset_m", [0.01])
def test_a_recorded_person_at_a_wall_shakes_no_loop(recorded_data, offset_m):
    person = recorded(recorded_data, offset_m)
    for kept in (STRICT, IDEAL):
        found = judged(wall(*kept, *person, duration_s=6.0))
        assert found.stable is True, found.why
        assert "not seen to come from the loop; the exact model" in found.why
    found = judged(wall("controller=tdpa", *person, duration_s=6.0))
    assert found.stable is None and "whether the loop keeps it up is not known" in found.why
    assert judged(wall(*DIRECT, *person, duration_s=6.0)).stable is False  # the control


@pytest.mark.parametrize(("hertz", "force_n"), [(1.0, 3.0), (5.0, 8.0)])
def test_a_force_that_throws_the_object_out_is_no_divergence(hertz, force_n):
    words = {"kind": "sinusoid", "frequency_hz": hertz, "force": force_n}
    texts = [f"user1.operator.{name}={value}" for name, value in words.items()]
    scenario = scenarios.load(
        "carry_16ms", settings_texts=["users=1", "task.kind=hold", *texts], duration_s=7.0
    )
    found = judged(scenario)
    assert (found.stable, found.instability) == (None, None)
    assert "left the workspace" in found.why and "the hands did the work of it" in found.why


def test_a_constant_force_that_pushes_the_object_to_a_stop_shakes_no_loop():
    words = ("operator.kind=none", "user1.operator.kind=constant", "user1.operator.force=0.5")
    for texts, stable in (((), True), (("controller=direct",), False)):
        scenario = scenarios.load("carry_16ms", settings_texts=[*words, *texts], duration_s=6.0)
        found = judged(scenario)
        assert found.stable is stable, found.why
    made = drove(simulated(scenario), scenario, 3.0, 6.0)  # the control: made on the way
    assert made.share < -0.1 and made.made_j > 1.0 and not made.by_hands


def test_an_arm_that_presses_its_device_against_a_stop_shakes_no_loop():
    """It is a passive arm that follows a smooth target: only the stops make its motion fast."""
    texts = "device.workspace_m=0.06", "task.distance_m=0.2"
    scenario = scenarios.load("carry_16ms", settings_texts=texts, duration_s=6.0)
    traces = simulated(scenario)
    assert max(user.x_m.max() for user in traces.users) == 0.06
    found = verdict(traces, scenario)
    assert found.stable is None and "a device met its stop 0.51 s" in found.why, found.why
    assert not any(user["blows"] for user in summary(traces, scenario)["users"])


@settings(max_examples=4)
@given(
    channel=st.sampled_from(["plain", "strict"]),
    delay_ms=st.floats(0.0, 60.0),
    stiffness=st.floats(100.0, 5000.0),
    start_s=st.floats(0.0, 3.0),
    length_s=st.floats(1.5, 3.0),
)
def test_a_passive_loop_never_drives_a_motion(channel, delay_ms, stiffness, start_s, length_s):
    texts = f"channel={channel}", f"link.delay_s={delay_ms / 1e3}"
    scenario = wall(*texts, f"server.contact_stiffness={stiffness}", duration_s=6.0)
    found = drove(simulated(scenario), scenario, start_s, start_s + length_s)
    assert found != UNKNOWN and not found.by_loop


def test_nothing_is_said_where_work_is_not_known():
    scenario = wall(*PLAIN, duration_s=4.0)
    traces = simulated(scenario)
    assert drove(traces, scenario, 1.0, 3.0) != UNKNOWN
    assert drove(traces, None, 1.0, 3.0) == UNKNOWN
    active = wall("server.coupling=unknown", "server.environment=active_wall", duration_s=4.0)
    assert drove(simulated(active), active, 1.0, 3.0).moved_j == 0.0
    alone = scenarios.load("carry_16ms", settings_texts=["channel=plain"], duration_s=4.0)
    assert drove(traces, alone, 1.0, 3.0).moved_j == 0.0  # the other user was not recorded


@pytest.mark.parametrize(("delay_s", "gave"), [(0.05, True), (0.0, False)])
def test_a_loop_that_shakes_at_the_largest_force_is_seen_within_a_second_and_a_half(delay_s, gave):
    """Its frequency is within the band of hands that close, and forces are at their limit."""
    texts = "controller=direct", f"link.delay_s={delay_s}", f"link.loss={0.3 * gave}"
    scenario = scenarios.load("carry_16ms", settings_texts=texts, duration_s=4.0)
    found = judged(scenario)
    assert (found.stable is False) is gave, found.why
    assert ("the loop gave the hands" in found.why) is gave


def test_where_no_device_moves_nothing_is_known_of_stability():
    scenario = scenarios.load("carry_16ms", settings_texts=["operator.kind=none"], duration_s=2.0)
    assert judged(scenario).stable is None
    assert "no device moved" in judged(scenario).why
