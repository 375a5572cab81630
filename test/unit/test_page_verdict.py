# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The verdict of a page while its session runs: that of the report's judge on the newest seconds;
force limits, an encoder, a new delay.
"""

import re

import pytest
from support.plain import load
from support.simulated import simulated

from pmwvc_analysis.budget.criterion import Finding
from pmwvc_analysis.budget.energy import user_energies
from pmwvc_analysis.traces.felt import felt, felt_words
from pmwvc_analysis.traces.stages import until
from pmwvc_analysis.verdicts import stability
from pmwvc_view.controls import changed
from pmwvc_view.description import lags, moving
from pmwvc_view.feed.feed import Feed
from pmwvc_view.feed.verdict import Judge, verdict
from pmwvc_view.protocol.snapshot import Layout
from pmwvc_view.session import ramped
from pmwvc_view.simulated import Simulation

MS = 1_000_000
PERIOD_S = 0.016


def told(name, seconds, settings_texts=(), targets=None, change=None):
    """Return feed, judge and messages of a session of a page, told eight times a second.

    Parameters
    ----------
    targets
        The hand's target at a time [s].
    change
        A time and what changes then: ``(time_s, path, value)``.
    """
    scenario = load(name, settings_texts=settings_texts)
    names = [user.name for user in scenario.users]
    simulation = Simulation(scenario)
    bodies = moving(simulation.scene)
    feed = Feed(Layout(names, scenario.dof, bodies), scenario, period_ns=16 * MS)
    judge = Judge(feed.tape, simulation.scene)
    options = {"exact_hands": names, "notices": []}
    feed.tape.zero(0)
    found = []
    for tick in range(16, 1000 * seconds, 16):
        if targets is not None:
            place = targets(tick * 1e-3)
            simulation.targets["user1"].append(place)
        if change is not None and tick >= 1e3 * change[0]:
            wanted = changed(scenario, dict([change[1:]]))
            following = ramped(scenario, wanted, over_s=PERIOD_S)
            simulation.change(following)
            scenario = following
        simulation.step_to(tick, feed)
        feed.others = lags(scenario, live=False)
        feed.rows(tick * MS)
        if tick % 128 == 0:
            judge.judge(scenario)
            found.append(verdict(feed, judge, scenario, **options))
    return feed, judge, found


LATE_WALL = ("channel=plain", "server.coupling=one_frame_late")


def test_wall_that_comes_late_shakes_the_device_though_its_channel_is_passive():
    _, _, found = told("wall", 10, (*LATE_WALL, "server.contact_stiffness=2000"))
    unstable = [each for each in found if each["verdict"].startswith("Not stable, ")]
    assert unstable
    for each in unstable:
        assert each["level"] == "bad" and "user1" in each["verdict"]
    # Wall and avatar have come apart: it is over, and not forgotten; the server was active.
    assert found[-1]["verdict"].startswith("Not passive: server with its environment, gave out")
    assert found[-1]["notices"][0].startswith("Not stable until ")


@pytest.mark.parametrize(
    ("name", "texts"),
    [
        ("carry_16ms", ("task.grip_rise_s=0.3",)),  # hands close fast, then carry
        ("wall", ("controller=direct", "link.delay_s=0.016")),
    ],
)
def test_window_that_holds_the_whole_session_is_judged_as_the_report_judges_it(name, texts):
    seconds = 5
    scenario = load(name, settings_texts=texts, duration_s=float(seconds))
    _, judge, found = told(name, seconds, texts)
    assert name == "wall" or says_no_shaking(found)
    shown = judge.traces(scenario)
    report = stability.verdict(until(simulated(scenario), shown.duration_s - 1e-9), scenario)
    page = stability.verdict(shown, scenario)
    assert (page.stable, page.instability) == (report.stable, report.instability)
    assert page.oscillation_m_s == pytest.approx(report.oscillation_m_s, rel=1e-6)


def says_no_shaking(found):
    levels = {each["level"] for each in found}
    return levels == {"caution", "good"} and not any(each["notices"] for each in found)


def test_a_hand_that_presses_a_late_wall_does_not_shake():
    _, _, found = told("wall", 5, (*LATE_WALL, "server.contact_stiffness=500"))
    assert says_no_shaking(found)


def test_person_who_taps_three_times_a_second_or_lets_go_does_not_shake_the_device():
    def targets(time_s):
        if time_s < 1.0 or 4.0 < time_s < 4.5:
            return None
        return -0.045 + (0.03 if time_s * 3.0 % 1.0 < 0.5 else 0.01)

    _, judge, found = told("wall", 7, ("operator.kind=remote",), targets)
    contact = judge.traces(load("wall")).server.contact[0]
    assert (contact[1:] != contact[:-1]).sum() > 4
    assert all("stable" not in each["verdict"] and not each["notices"] for each in found)


def test_a_box_that_slips_in_a_grip_is_a_notice_of_the_page():
    haste = ("task.grip_s=0.3", "task.grip_rise_s=0.5", "task.move_s=1.5", "operator.squeeze=0.9")
    _, _, found = told("lift", 4, haste)
    assert found[0]["notices"] == []
    (slip,) = found[-1]["notices"]
    assert re.match(r"box, at 2\.\d\d s: slipped by \d+\.\d mm in the grip of user1 and", slip)


def test_a_held_key_over_a_lossy_link_does_not_shake_the_device():
    """The wall answers in jolts where packets wait."""

    def target(time_s):
        pushed = 0.06 * min(max(time_s - 2.0, 0.0), 1.6) - 0.04 * min(max(time_s - 5.0, 0.0), 1.0)
        return None if time_s < 1.5 else -0.05 + pushed

    lossy = ("operator.kind=remote", "channel=strict", "link.delay_s=0.016", "link.loss=0.2")
    _, _, found = told("wall", 6, (*lossy, "seed=1"), target)
    said = [each["verdict"] for each in found if "Not stable" in each["verdict"]]
    said += [notice for each in found for notice in each["notices"] if "Not stable" in notice]
    assert not said


SLOW = ("operator.kind=remote", "controller=direct", "link.delay_s=0.03")


def test_slow_shaking_that_the_loop_drives_is_named_whatever_hands_may_do():
    """Within the band of a person with a pointer, who holds still."""
    _, _, found = told("wall", 6, SLOW, lambda time_s: None if time_s < 1.0 else -0.005)
    assert found[-1]["verdict"].startswith("Not stable, ")
    _, _, found = told("wall", 6, SLOW[:1], lambda time_s: None if time_s < 1.0 else -0.005)
    assert found[-1]["level"] == "good"  # with waves the same hand rests


def test_force_that_stays_at_its_limit_is_said():
    settings_texts = ("operator.kind=remote", "safety.max_force=0.3")
    _, _, found = told("wall", 4, settings_texts, lambda _: 0.0)
    assert found[-1]["level"] == "caution"
    assert "at its limit: force of user1 (0.3 N)" in found[-1]["verdict"]


def test_energy_that_was_lent_is_named_with_what_no_link_gave_out():
    feed, judge, found = told("wall", 2, ("channel=strict", "task.grip_rise_s=0.3"))
    said = found[-1]["verdict"]
    assert "it received and was lent at the start (" in said and found[-1]["level"] == "good"
    lent = Finding("user1", "hand_port", False, least_j=-1e-3, least_s=0.5)
    feed.worst["user1", "hand_port"] = lent
    options = {"exact_hands": ["user1"], "notices": []}
    bad = verdict(feed, judge, load("wall"), **options)
    assert bad["verdict"].startswith("Not passive: user1, port of the hand, gave out 1 mJ")


def test_what_a_hand_has_felt_is_told_as_the_report_tells_it():
    scenario = load("wall", duration_s=4.0)
    traces = simulated(scenario)
    *_, (*_, last) = told("wall", 4)
    said, whole = last["users"]["user1"]["felt"], felt(traces, traces.users[0], scenario)
    assert re.fullmatch(r"buzz .* N rms above 60 Hz, steps .* N in 1 ms, never below .* N", said)
    assert said == felt_words(whole._asdict())


ENCODER = ("device.encoder_step_m=50e-6", "device.velocity=euler")


def test_hand_with_an_encoder_is_judged_by_its_true_motion_as_in_the_report():
    scenario = load("wall", settings_texts=ENCODER, duration_s=4.0)
    feed, _, found = told("wall", 4, ENCODER)
    energy = user_energies(simulated(scenario), scenario)[0]
    least_j = feed.worst["user1", "hand_port"].least_j
    assert least_j == pytest.approx(energy.joint.balance_j.min(), rel=1e-6) and least_j < -1e-4
    assert found[-1]["verdict"].startswith("Not passive: user1, port of the hand, gave out 140 µJ")
