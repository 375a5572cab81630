# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The verdict on stability, and the kinds of instability."""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support import handmade
from support.handmade import oscillating, session

from pmwvc_analysis.traces.thresholds import OSCILLATION_M_S
from pmwvc_analysis.verdicts.stability import verdict


def judged(traces, **overrides):
    """The kind of instability, None for stable."""
    return verdict(traces, handmade.scenario(**overrides)).instability


@pytest.mark.parametrize(("share", "instability"), [(0.9, None), (1.2, "sustained oscillation")])
@pytest.mark.parametrize("hertz", [3.0, 20.0, 200.0])
def test_an_oscillation_counts_from_a_millimetre_per_second(hertz, share, instability):
    traces = oscillating(session(), rms_m_s=share * OSCILLATION_M_S, hertz=hertz)
    assert judged(traces) == instability


@settings(max_examples=25)
@given(hertz=st.floats(2.0, 100.0), fell=st.floats(0.2, 0.9), rms_m_s=st.floats(2e-3, 0.04))
def test_an_oscillation_that_decays_is_not_said_to_be_kept_up(hertz, fell, rms_m_s):
    """From the first third of what is judged to the last, 4/3 s here, it falls by so much."""
    tau_s = -4.0 / 3.0 / np.log(1.0 - fell)
    fades = oscillating(session(), rms_m_s=rms_m_s, hertz=hertz, rate_per_s=-1.0 / tau_s)
    kept = oscillating(session(), rms_m_s=rms_m_s, hertz=hertz)
    assert judged(fades) is None
    assert judged(kept) == "sustained oscillation"


def test_a_slow_decay_is_named_with_its_amount():
    traces = oscillating(session(), rms_m_s=20e-3, hertz=10.0, rate_per_s=-0.2)
    found = verdict(traces, handmade.scenario())
    assert found.stable is None
    less = re.search(r"(\d+)% less than 1.3 s earlier: only a longer session", found.why)
    assert float(less[1]) == pytest.approx(100.0 * (1.0 - np.exp(-0.2 * 4.0 / 3.0)), abs=3.0)


def test_a_burst_is_stable():
    traces = oscillating(session(), rms_m_s=0.1, hertz=30.0, during_s=(3.0, 3.2))
    assert judged(traces) is None


@pytest.mark.parametrize(("gain", "kind"), [(1.2, "diverged"), (1.0, "sustained oscillation")])
def test_an_oscillation_that_grows_has_diverged_unless_the_loop_is_passive(gain, kind):
    traces = oscillating(session(gain=gain), rms_m_s=0.05, hertz=10.0, rate_per_s=1.0)
    found = verdict(traces, handmade.scenario())
    assert found.instability == kind and "growing" in found.why


def test_a_number_that_is_none_has_diverged():
    traces = session()
    traces.server.x_o[300:] = np.nan
    assert judged(traces) == "diverged"


@pytest.mark.parametrize(("position_m", "stable"), [(0.19, True), (0.31, False)])
def test_leaving_the_workspace_has_diverged_unless_the_loop_is_passive(position_m, stable):
    for gain in (1.2, 1.0):
        traces = session(gain=gain)
        traces.users[1].x_m[-100:] = position_m
        found = verdict(traces, handmade.scenario(operator__kind="hand"))
        assert found.stable is (True if stable else None if gain == 1.0 else False), found.why


def test_an_object_drifting_evenly_is_stable():
    traces = session()
    traces.server.x_o += 0.02 * traces.server.time_s[:, np.newaxis]
    traces.server.xd_o += 0.02
    assert judged(traces) is None


def late_packets(traces, *, every):
    """Let some packets to the first user come 6 ms late."""
    traces.packets["/user1/wave_down"].time_s[::every] += 6e-3
    return traces


@pytest.mark.parametrize(("every", "stable"), [(3, None), (10_000, False)])
def test_shaking_is_the_loop_s_only_where_packets_come_evenly(every, stable):
    traces = late_packets(session(), every=every)
    user = traces.users[0]
    user.xd_m = user.xd_m + np.random.default_rng(5).normal(0.0, 3e-3, user.xd_m.shape)
    found = verdict(traces, handmade.scenario())
    assert found.stable is stable
    if stable is None:
        assert "58% of the time went by in waiting for late packets" in found.why


def test_packets_that_come_late_do_not_matter_to_what_rests():
    found = verdict(late_packets(session(), every=3), handmade.scenario())
    assert found.stable is True


@pytest.mark.parametrize(
    ("operator", "stable"),
    [
        ({"operator__kind": "sinusoid", "operator__frequency_hz": 3.0}, True),
        ({"operator__kind": "constant"}, False),
    ],
)
def test_what_the_operator_does_on_purpose_is_no_oscillation(operator, stable):
    traces = oscillating(session(), rms_m_s=0.05, hertz=3.0)
    assert (judged(traces, **operator) is None) is stable


DRIVEN = {
    "server__coupling": "unknown",
    "server__environment": "active_wall",
    "server__active_wall__frequency_hz": 1.0,
}


@pytest.mark.parametrize(
    ("hertz", "environment", "stable"),
    [
        (1.0, DRIVEN, True),
        (2.0, DRIVEN, True),  # a harmonic: the hand is let go at times
        (7.0, DRIVEN, False),  # the loop's
        (1.0, DRIVEN | {"server__active_wall__amplitude_m": 0.0}, False),
        (1.0, DRIVEN | {"server__environment": "wall"}, False),
    ],
)
def test_what_the_environment_is_driven_with_is_no_oscillation(hertz, environment, stable):
    traces = oscillating(session(), rms_m_s=0.04, hertz=hertz)
    assert (judged(traces, **environment) is None) is stable


def test_a_driven_environment_does_not_hide_a_loop_that_swings_up():
    traces = oscillating(session(), rms_m_s=0.05, hertz=10.0, rate_per_s=1.0)
    assert judged(traces, **DRIVEN) == "sustained oscillation"


def test_a_hand_that_carries_moves_on_purpose_below_two_hertz():
    carry = {"operator__kind": "hand", "task__kind": "carry"}
    slow = oscillating(session(), rms_m_s=0.05, hertz=0.7)
    fast = oscillating(session(), rms_m_s=0.05, hertz=7.0)
    assert judged(slow, **carry) is None
    assert judged(fast, **carry) == "sustained oscillation"


@pytest.mark.parametrize("shaken_m_s", [0.0, 20e-3])
def test_the_steps_of_an_encoder_are_no_oscillation_and_hide_none(shaken_m_s):
    """Beside the noise from tick to tick, 82 mm/s, 50 mm/s of a direct coupling were "stable"."""
    step_m = 1e-4
    traces = oscillating(session(), rms_m_s=shaken_m_s, hertz=8.0)
    user = traces.users[0]
    user.x_m = user.x_m + np.cumsum(user.xd_m, axis=0) * user.tick_s * (shaken_m_s > 0.0)
    noise = np.random.default_rng(3).uniform(-0.5, 0.5, user.x_m.shape) * step_m
    user.x_m = user.x_m + noise
    user.xd_m = user.xd_m + np.diff(noise, axis=0, prepend=0.0) / user.tick_s
    encoder = {"device__encoder_step_m": step_m, "device__velocity": "euler"}
    assert judged(traces, **encoder) == ("sustained oscillation" if shaken_m_s else None)
    assert judged(traces) is not None


def test_a_session_without_a_recorded_user_is_neither_stable_nor_unstable():
    traces = session()
    traces.users = []
    assert verdict(traces, handmade.scenario())[::2] == (None, "no user was ever coupled")


@pytest.mark.parametrize("shaken_m_s", [0.0, 20e-3])
def test_a_session_too_short_to_tell_is_neither_stable_nor_unstable(shaken_m_s):
    traces = oscillating(session(duration_s=0.8), rms_m_s=shaken_m_s, hertz=10.0)
    found = verdict(traces, handmade.scenario())
    assert (found.stable, found.instability) == (None, None)
    assert found.why == "0.8 s are too short to judge, 1.5 s at least"


@pytest.mark.parametrize(
    ("rms_m_s", "rate_per_s", "words"),
    [
        (0.5e-3, 0.0, "0.5 mm/s at the end (limit 1 mm/s)"),
        (20e-3, -1.5, "mm/s at the end (limit 1 mm/s), and decays"),
    ],
)
def test_a_stable_session_has_the_motion_that_is_left_in_its_verdict(rms_m_s, rate_per_s, words):
    traces = oscillating(session(), rms_m_s=rms_m_s, hertz=20.0, rate_per_s=rate_per_s)
    found = verdict(traces, handmade.scenario())
    assert found.stable is True and words in found.why


def touching(traces, *changes_s):
    """Let contact be made or lost at times [s]."""
    for contact in traces.server.contact:
        contact[:] = False
        for change_s in changes_s:
            contact[traces.server.time_s >= change_s] ^= True
    return traces


def test_a_vibration_right_after_contact_is_neither_stable_nor_unstable():
    traces = oscillating(session(), rms_m_s=20e-3, hertz=30.0, during_s=(3.4, 4.0))
    found = verdict(touching(traces, 3.4), handmade.scenario())
    assert (found.stable, found.instability) == (None, None)
    assert found.why.startswith("contact was made or lost 0.60 s before the end; user1's device")
    assert verdict(touching(session(), 3.4), handmade.scenario()).stable is True


def test_a_vibration_after_contact_is_judged_by_whether_it_dies_out():
    decaying = oscillating(
        session(), rms_m_s=0.5, hertz=30.0, rate_per_s=-2.0, during_s=(2.4, 4.0)
    )
    assert judged(touching(decaying, 2.4)) is None
    lasting = oscillating(session(), rms_m_s=20e-3, hertz=30.0, during_s=(2.4, 4.0))
    assert judged(touching(lasting, 2.4)) == "sustained oscillation"


def test_contact_that_ends_because_users_leave_with_the_session_excuses_no_oscillation():
    traces = oscillating(session(), rms_m_s=20e-3, hertz=10.0)
    traces.server.time_s[-1] = traces.duration_s + 0.05  # a live server runs on
    left = touching(traces, 1.0, traces.duration_s + 0.01)
    assert judged(left) == "sustained oscillation"


def test_contact_that_comes_and_goes_excuses_no_oscillation():
    traces = oscillating(session(), rms_m_s=20e-3, hertz=10.0)
    assert judged(touching(traces, *np.arange(2.0, 3.99, 0.1))) == "sustained oscillation"


def test_contact_that_came_and_went_and_is_over_disturbed_what_follows():
    """A body that slid out of a grip: the hand that swings out after it is not the loop's."""
    traces = oscillating(session(), rms_m_s=20e-3, hertz=10.0, during_s=(2.6, 4.0))
    found = verdict(touching(traces, *np.arange(2.6, 3.5, 0.1)), handmade.scenario())
    assert found.stable is None and found.why.startswith("contact was made or lost 0.59 s")


@pytest.mark.parametrize("held", [True, False])
def test_the_object_is_judged_while_a_user_touches_it(held):
    """Let go of, it swings by itself, or falls as fast as it likes."""
    traces = session()
    server = traces.server
    server.xd_o[:] = 0.03 * np.sin(2.0 * np.pi * 10.0 * server.time_s)[:, np.newaxis]
    found = verdict(touching(traces, *([0.0] if held else [])), handmade.scenario())
    assert found.stable is not held
    assert (found.oscillation_m_s > 0.01) == held
