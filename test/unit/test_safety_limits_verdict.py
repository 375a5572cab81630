# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The verdict on stability where safety limits took over, and where packets came late."""

import numpy as np
import pytest
from support import handmade
from support.handmade import oscillating, session

from pmwvc_analysis.traces.arrivals import waited
from pmwvc_analysis.verdicts.stability import verdict
from pmwvc_bringup.scenarios import load
from pmwvc_core.frame import LIVE
from pmwvc_core.network.in_flight import RecordedFate, RecordedLink
from pmwvc_core.simulation.conditions import Conditions
from pmwvc_core.simulation.session import simulate_one


def judged(traces):
    """The kind of instability, None for stable."""
    return verdict(traces, handmade.scenario()).instability


TOO_FAST = "faster than 1.5 m/s: no force until re-armed"
LOST = "device silent for more than 1 s: no force until re-armed"


@pytest.mark.parametrize(
    ("reason", "stable", "instability"),
    [(TOO_FAST, False, "limited by safety"), (LOST, None, None)],
)
def test_a_fault_is_named_as_safety_and_a_lost_device_says_nothing_of_the_loop(
    reason, stable, instability
):
    traces = session(gain=1.1)
    traces.users[0].state[400:] = 3
    traces.users[0].reason[400:] = [reason] * 100
    found = verdict(traces, handmade.scenario())
    assert (found.stable, found.instability) == (stable, instability)
    assert f"user1: safety fault at 3.21 s ({reason})" in found.why


PULLED = "operator.kind=constant operator.force=-8 master.impedance=2".split()
NAIVE = "operator.kind=constant operator.force=3 controller=direct link.delay_s=0.03".split()


@pytest.mark.parametrize(("settings", "stable"), [(PULLED, None), (NAIVE, False)])
def test_a_fault_is_the_loop_s_unless_hands_threw_the_device(settings, stable):
    """Pulled away from a wall by 8 N it was "not stable", with every port passive."""
    scenario = load("wall", settings_texts=settings, duration_s=4.0)
    found = verdict(simulate_one(scenario), scenario)
    assert found.stable is stable and "safety fault" in found.why
    assert ("; the hands did the work of it" in found.why) is (stable is None)


@pytest.mark.parametrize(
    ("times", "reason", "instability"),
    [
        (3, "faster than 1 m/s: damping only", "limited by safety"),
        (2, "faster than 1 m/s: damping only", None),
        (9, "server silent: damping only", None),
    ],
)
def test_being_braked_again_and_again_is_named_as_safety(times, reason, instability):
    traces = session(gain=1.1)
    user = traces.users[0]
    for place in range(times):
        user.state[300 + 10 * place] = 2
        user.reason[300 + 10 * place] = reason
    assert judged(traces) == instability


@pytest.mark.parametrize(("blocks", "instability"), [(12, None), (13, "limited by safety")])
def test_being_braked_for_long_is_named_as_safety(blocks, instability):
    """Of 250 blocks in the second half: a twentieth, and a block more."""
    traces = session(gain=1.1)
    user = traces.users[0]
    user.state[300 : 300 + blocks] = 2
    user.reason[300 : 300 + blocks] = ["faster than 1 m/s: damping only"] * blocks
    assert judged(traces) == instability


def shortened_again_and_again():
    traces = session()
    user = traces.users[0]
    shortened = np.sin(2 * np.pi * 5.0 * user.time_s) > 0.5
    user.f_applied = np.where(shortened[:, np.newaxis], 0.5 * user.f_m, user.f_m)
    return traces


def test_force_shortened_again_and_again_is_named_as_safety():
    assert judged(shortened_again_and_again()) == "limited by safety"


@pytest.mark.parametrize(
    ("shaken_m_s", "instability", "stable"),
    [(5e-3, "limited by safety", False), (0.0, None, None)],
)
def test_force_at_its_limit_is_the_loop_s_where_something_oscillates(
    shaken_m_s, instability, stable
):
    """Else it may be that of a hand that presses harder than the device can."""
    traces = oscillating(session(), rms_m_s=shaken_m_s, hertz=5.0)
    user = traces.users[0]
    user.f_m = user.f_m * (1.0 + 0.5 * np.sin(2 * np.pi * 2.0 * user.time_s)[:, np.newaxis])
    user.f_applied = np.minimum(user.f_m, 1.2)
    found = verdict(traces, handmade.scenario())
    assert (found.instability, found.stable) == (instability, stable)
    assert "user1: the force was limited" in found.why


def test_force_shortened_once_is_no_instability():
    traces = session()
    user = traces.users[0]
    once = (user.time_s > 2.5) & (user.time_s < 2.8)
    user.f_applied = np.where(once[:, np.newaxis], 0.5 * user.f_m, user.f_m)
    assert judged(traces) is None


def test_a_force_that_returns_after_a_stall_was_not_braked_for_speed():
    traces = session()
    user = traces.users[0]
    for place in range(5):
        block = 300 + 20 * place
        user.state[block] = 0
        user.reason[block] = "soft start"
    assert judged(traces) is None


DOWN = "/user1/wave_down"
LATE_S = (2.1, 2.7, 3.3)  # packets of the first user that come 30 ms late


def with_late_packets(traces):
    packets = traces.packets[DOWN]
    for late_s in LATE_S:
        rows = (packets.time_s >= late_s) & (packets.time_s < late_s + 0.03)
        packets.time_s[rows] = late_s + 0.03
    return traces


def test_force_limited_beside_late_packets_is_not_judged():
    """A blow after each of them is the network's, or that of a machine that stalls."""
    traces = shortened_again_and_again()
    assert judged(traces) == "limited by safety"
    found = verdict(with_late_packets(traces), handmade.scenario())
    assert found.stable is None and "the force was limited" in found.why
    assert "late packets" in found.why


@pytest.mark.parametrize("hertz", [8.0, 30.0])
def test_motion_beside_late_packets_is_not_judged(hertz):
    shaken = oscillating(session(), rms_m_s=5e-3, hertz=hertz)
    assert verdict(shaken, handmade.scenario()).stable is False
    found = verdict(with_late_packets(shaken), handmade.scenario())
    assert found.stable is None and "late packets" in found.why


def stalled_link(rng, *, frame_s, length_s):
    """Return a link that lets nothing out now and then, and then all of it at once."""
    stalls, at_s = [], 0.0
    while at_s < length_s:
        at_s += rng.exponential(0.5)
        stalls.append((at_s, at_s + rng.choice([0.01, 0.03, 0.06, 0.1, 0.15, 0.3])))
        at_s = stalls[-1][1]
    record = {}
    for number in range(1, round(length_s / frame_s) + 3):
        sent_s = out_s = (number - 1) * frame_s
        for from_s, until_s in stalls:
            out_s = until_s if from_s <= out_s < until_s else out_s
        record[number] = (RecordedFate(round((out_s - sent_s) * 1e9)),)
    return RecordedLink(record)


def stalled(scenario, seed):
    """Simulate a scenario of one user whose links stall."""
    rng = np.random.default_rng(seed)
    frame_s = scenario.users[0].master.frame_s
    links = {
        f"user1/{way}": stalled_link(rng, frame_s=frame_s, length_s=scenario.duration_s)
        for way in ("up", "down")
    }
    made = {name: (lambda link=link: link) for name, link in links.items()}
    return simulate_one(scenario, Conditions(schedule=LIVE, links=made))


# of 400, those whose motion has one frequency, or which end in a stall
SEEDS = (140, 180, 210, 364)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_loop_that_settles_is_never_blamed_for_what_stalls_set_off(seed):
    scenario = load("wall_slow", settings_texts=["channel=strict"], duration_s=3.5)
    found = verdict(stalled(scenario, seed), scenario)
    assert found.stable is not False, (found.instability, found.why)


def test_what_has_not_come_by_the_end_is_waited_for():
    traces = session()
    packets = traces.packets[DOWN]
    assert waited([packets], 2.0, 4.0) == 0.0
    packets.time_s[packets.time_s > 3.5] = np.inf  # none of them came
    here = np.isfinite(packets.time_s)
    for name in ("time_s", "seq", "epoch", "period_s"):
        setattr(packets, name, getattr(packets, name)[here])
    last_s = packets.time_s[-1]
    assert waited([packets], 2.0, 4.0) == pytest.approx((4.0 - last_s) / 2.0)
    assert waited([packets], 2.0, 10.0) == 0.0  # nobody is there any more
    packets.time_s[-1] = 5.0  # it came after the end that is judged
    assert waited([packets], 3.0, 4.0) == pytest.approx(4.0 - packets.time_s[-2])
