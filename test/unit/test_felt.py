# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The force that a hand feels: steps, least force and dropouts, each with a control."""

import numpy as np
import pytest
from support import handmade
from support.handmade import FORCE_N, session, without_blocks

from pmwvc_analysis.compare.measures import measures
from pmwvc_analysis.report.report import render
from pmwvc_analysis.traces.felt import felt, felt_words
from pmwvc_analysis.traces.thresholds import IMPACT_S
from pmwvc_analysis.verdicts import check
from pmwvc_analysis.verdicts.verdicts import summary
from pmwvc_bringup.session.terminal import verdict_lines as printed


def felt_of(traces, **overrides):
    return felt(traces, traces.users[0], handmade.scenario(**overrides))


def pressed(*, dof=1):
    """A press whose avatar touches from the begin of the press on."""
    traces = session(dof=dof)
    for contact in traces.server.contact:
        contact[traces.server.time_s < 0.5] = False
    return traces


def test_a_steady_press_has_neither_steps_nor_dropouts():
    traces = pressed()
    found = felt_of(traces)
    assert not any("ms" in line for line in printed(summary(traces, handmade.scenario())))
    assert found.force_step_max_n < 0.03  # the staircase of its frames
    assert found.blows == 0
    assert found.force_undisturbed_n == pytest.approx(FORCE_N, rel=1e-3)
    assert found.force_least_n == pytest.approx(FORCE_N, rel=1e-3)
    assert found.dropout_s == 0.0


def test_what_an_outage_leaves_of_a_grip_is_not_what_was_held():
    """Of 1.6 N held for 2.4 s 0.46 N were left for longer: "never below half of 0.46 N"."""
    traces = pressed()
    user = traces.users[0]
    user.state[300:302] = 2
    user.f_applied[user.time_s > 2.4] *= 0.35
    found = felt_of(traces)
    assert found.force_undisturbed_n > 0.9 * FORCE_N
    assert found.dropout_s == pytest.approx(1.6, abs=0.01)
    assert found.disturbed_s == pytest.approx(1.6, abs=0.02)


@pytest.mark.parametrize("dof", [1, 3])
def test_a_force_that_is_missing_for_20_ms_is_named_with_amount_time_and_length(dof):
    traces = pressed(dof=dof)
    user = traces.users[0]
    user.f_applied[(user.time_s > 2.9995) & (user.time_s < 3.0195), 0] = 0.2 * FORCE_N
    found = felt_of(traces, dof=dof)
    assert found.force_step_max_n == pytest.approx(0.8 * FORCE_N, rel=1e-3)
    assert found.force_step_max_s == pytest.approx(3.0)
    assert found.blows == 2  # away, and back
    assert found.force_least_n == pytest.approx(0.2 * FORCE_N)
    assert found.dropout_s == pytest.approx(0.020)
    result = summary(traces, handmade.scenario(dof=dof))
    assert [user["blows"] for user in result["users"]] == [2, 0]
    assert result["users"][0]["dropout_s"] == found.dropout_s
    text = "user1: the force changed by 0.80 N within 1 ms at 3.00 s and 1 more above 0.3 N"
    assert f"{text}." in [line.text for line in check.lines(result)]
    assert f"  {text}." in printed(result)
    compared = measures(traces, handmade.scenario(dof=dof))
    assert compared["force_step_max_n"] == found.force_step_max_n
    assert compared["force_least_n"] == found.force_least_n
    assert compared["dropout_s"] == found.dropout_s


def test_a_force_that_fades_is_missing_without_a_blow():
    traces = pressed()
    user = traces.users[0]
    user.f_applied[:, 0] *= 1.0 - np.clip(1.0 - np.abs(user.time_s - 3.0) / 0.1, 0.0, 1.0)
    found = felt_of(traces)
    assert found.blows == 0
    assert found.dropout_s == pytest.approx(0.1, abs=0.003)
    assert found.force_least_n == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("tick_s", [0.00025, 0.001])
def test_a_step_is_what_changes_within_a_millisecond_whatever_the_tick(tick_s):
    traces = session()
    user = traces.users[0]
    user.time_s, user.block_time_s = (t * tick_s / 0.001 for t in (user.time_s, user.block_time_s))
    user.tick_s = tick_s
    user.f_applied[:] = 0.1 * np.minimum(np.maximum(np.arange(4000) - 3000, 0), 10)[:, None]
    found = felt(traces, user, None)
    assert found.force_step_max_n == pytest.approx(0.1 * 0.001 / tick_s)
    assert found.blows == int(tick_s < 0.001)


@pytest.mark.parametrize(("kind", "blows"), [("chirp", 0), ("sinusoid", 1)])
def test_what_a_fast_hand_makes_of_its_own_force_is_no_blow_but_a_jump_is(kind, blows):
    """3 N at 20 Hz change by up to 0.38 N in 1 ms; nothing slower than the chirp makes that."""
    traces = pressed()
    user = traces.users[0]
    user.f_applied[:, 0] += 3.0 * np.sin(2.0 * np.pi * 20.0 * user.time_s)
    swings = felt_of(traces, operator__kind=kind)
    assert swings.force_step_max_n == pytest.approx(0.38, abs=0.02)
    assert bool(swings.blows) == bool(blows)
    user.f_applied[user.time_s > 3.0, 0] += 4.0
    assert felt_of(traces, operator__kind="chirp").blows == 1


def test_an_impact_is_no_fault():
    traces = pressed()
    user = traces.users[0]
    user.f_applied[user.time_s > 0.52, 0] += 1.0
    assert felt_of(traces).blows == 0
    traces.server.contact[0][traces.server.time_s >= 0.51 - IMPACT_S] = True  # has long touched
    assert felt_of(traces).force_step_max_n == pytest.approx(1.0, abs=0.01)


def test_a_force_held_through_a_stall_steps_when_the_loop_goes_on_and_a_hole_hides_it():
    traces = pressed()
    user = without_blocks(traces.users[0], slice(300, 310))
    later = user.time_s > 2.45
    user.f_applied[later, 0] -= 0.7 * np.clip((3.0 - user.time_s[later]) / 0.5, 0.0, 1.0)
    assert felt_of(traces).blows == 0
    user.block_number = np.arange(len(user.block_time_s)) + 1
    found = felt_of(traces)
    assert found.force_step_max_n == pytest.approx(0.7, abs=0.01)
    assert found.force_step_max_s == pytest.approx(2.48)
    assert found.dropout_s == pytest.approx(0.163, abs=0.002)


@pytest.mark.parametrize("kind", ["sinusoid", "remote"])
def test_who_does_not_mean_to_hold_a_force_loses_none(kind):
    found = felt_of(pressed(), operator__kind=kind)
    assert found[3:6] == (None, None, None)
    assert found.force_step_max_n > 0.0


def test_the_time_before_the_hand_has_closed_is_no_dropout():
    closing = {"operator__kind": "hand", "task__kind": "hold", "task__grip_s": 0.5}
    traces = pressed()
    user = traces.users[0]
    user.f_applied[400, 0] = 2.0 * FORCE_N  # a jolt before
    assert felt_of(traces, **closing).dropout_s == 0.0
    user.f_applied[2500:2600, 0] = 0.0
    assert felt_of(traces, **closing).dropout_s == pytest.approx(0.1)


def test_without_a_server_or_a_scenario_only_steps_are_known():
    traces = pressed()
    assert felt(traces, traces.users[0], None)[3:6] == (None, None, None)
    traces.server = None
    assert felt_of(traces)[3:6] == (None, None, None)
    assert felt_of(traces).force_step_max_n < 0.03


@pytest.mark.parametrize(("frame_s", "part"), [(0.008, 1.0), (0.004, 1.0), (0.001, 0.0)])
def test_buzz_of_a_staircase_is_its_step_over_the_root_of_twelve(frame_s, part):
    """A sawtooth of b a T about a ramp, sampled M times a frame: b a T sqrt((1 - 1/M^2)/12)."""
    traces = pressed()
    user, b, a = traces.users[0], 25.0, 2.0
    m = round(frame_s / user.tick_s)
    user.f_applied[:, 0] = b * a * frame_s * (np.arange(len(user.time_s)) // m)  # in 4 s 200 N
    wanted = b * a * frame_s * np.sqrt((1.0 - 1.0 / m**2) / 12.0)
    # The control: a ramp without steps does not buzz.
    assert felt_of(traces).buzz_n == pytest.approx(part * wanted, rel=0.01, abs=1e-3)


def test_buzz_is_what_lies_above_60_hz_and_not_what_hands_do():
    traces = pressed()
    user = traces.users[0]
    user.f_applied[:, 0] += 2.0 * np.sin(2 * np.pi * 8.0 * user.time_s)
    assert felt_of(traces).buzz_n < 1e-3
    user.f_applied[:, 0] += 0.1 * np.sin(2 * np.pi * 125.0 * user.time_s)
    found = felt_of(traces)
    assert found.buzz_n == pytest.approx(0.1 / np.sqrt(2.0), rel=0.01)
    text = "buzz 0.071 N rms above 60 Hz"
    assert felt_words(found._asdict()).startswith(text)
    result = summary(traces, handmade.scenario())
    assert result["users"][0]["buzz_n"] == found.buzz_n
    assert f"Felt by user1: {text}" in render(traces, handmade.scenario(), result, [])
    assert measures(traces, handmade.scenario())["buzz_n"] == found.buzz_n


def test_neither_an_impact_nor_the_time_before_coupling_buzzes_and_nothing_rings_into_the_rest():
    traces = pressed()
    user, server = traces.users[0], traces.server
    quiet = felt_of(traces).buzz_n
    shakes = np.sin(2 * np.pi * 125.0 * user.time_s)
    user.f_applied[:, 0] += shakes * ((user.time_s >= 2.0) & (user.time_s < 2.0 + IMPACT_S))
    assert felt_of(traces).buzz_n > 0.2  # the control: no contact is made there
    server.contact[0][(server.time_s > 1.9) & (server.time_s < 1.995)] = False  # now there is
    assert felt_of(traces).buzz_n == pytest.approx(quiet, abs=1e-3)
    user.f_applied[:, 0] += shakes * (user.time_s < 0.4)
    assert felt_of(traces).buzz_n > 0.1
    user.state[user.block_time_s < 0.41] = 0  # starting
    assert felt_of(traces).buzz_n == pytest.approx(quiet, abs=1e-3)


def test_buzz_of_a_loop_too_slow_for_it_is_unknown():
    traces = session()
    user = traces.users[0]
    user.time_s, user.block_time_s, user.tick_s = 8 * user.time_s, 8 * user.block_time_s, 0.008
    assert felt(traces, user, None).buzz_n is None
    assert "buzz" not in felt_words(felt(traces, user, None)._asdict())


@pytest.mark.parametrize(("environment", "slipped", "dropout_s", "blows"), [
    ("body", True, 0.0, 0), ("cube", True, 0.3, 1), ("body", False, 0.3, 2),
])  # fmt: skip
def test_what_slips_out_of_a_grip_is_no_fault_of_the_loop(environment, slipped, dropout_s, blows):
    """The control: a force that is missing while the avatar has it is one; so is a lost cube."""
    traces = pressed()
    user, server = traces.users[0], traces.server
    user.f_applied[(user.time_s > 2.9995) & (user.time_s < 3.2995), 0] = 0.0
    if slipped:
        apart = (server.time_s > 2.98) & (server.time_s < 3.31)
        server.f_s[0][apart], server.contact[0][apart & (server.time_s < 3.29)] = 0.0, False
    of = {"server__coupling": "unknown", "server__environment": environment}
    found = felt_of(traces, **of)
    assert found.dropout_s == pytest.approx(dropout_s, abs=1e-6)
    assert found.blows == blows
