# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The frame protocol driven by hand: no event schedule, no threads, no clock; its packets'
content.
"""

import numpy as np
import pytest
from support import plain as scenarios

from pmwvc_core.controllers.library import LIBRARY
from pmwvc_core.ends.server_end import ServerEnd
from pmwvc_core.ends.user_end import UserEnd
from pmwvc_core.frame import AT_ONCE, LIVE, DeviceSample, FrameSchedule
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.simulation.conditions import Conditions
from pmwvc_core.simulation.session import SteppedSession, simulate_one
from pmwvc_core.transport.packet import FLAG_DIRECT

TICK_NS = 1_000_000


@pytest.fixture(scope="module")
def scenario():
    soon = ("safety.soft_start_s=0.05", "task.grip_s=0.05", "task.grip_rise_s=0.3")
    return scenarios.load("carry_16ms", settings_texts=("link.delay_s=0", *soon), duration_s=1.0)


def forces(scenario, schedule):
    """Return the forces of every user ``(users, ticks)`` by calls of the two objects alone."""
    users = SteppedSession(scenario).users  # devices and hands only
    loops = [
        UserEnd(user, scenario, epoch=i + 1, schedule=schedule)
        for i, user in enumerate(scenario.users)
    ]
    server = ServerEnd(scenario)
    period = scenario.period_ticks
    phase = schedule.server_tick(tick_s=scenario.tick_s, period_ticks=period)
    up, down = [[] for _ in users], [[] for _ in users]
    found = [[] for _ in users]
    for tick in range(round(scenario.duration_s / scenario.tick_s)):
        now_ns = tick * TICK_NS
        samples = [user.device.sample for user in users]
        if schedule == AT_ONCE:  # packet, step and answer are one instant
            for loop, sample, link in zip(loops, samples, up, strict=True):
                link.append(loop.start_frame(tick, now_ns, sample))
        if tick % period == phase:
            packets = [[packet for packet in link if packet is not None] for link in up]
            answers, _ = server.tick(now_ns, packets)
            for link, back, answer in zip(up, down, answers, strict=True):
                link.clear()
                back += [answer] if answer is not None else []
        for i, (loop, user) in enumerate(zip(loops, users, strict=True)):
            acts = loop.s.coupled or (schedule == AT_ONCE and loop.s.limits.ready)
            user.device.sense(acts)
            force, packet, _ = loop.tick(tick, now_ns, samples[i], tuple(down[i]))
            down[i].clear()
            up[i].append(packet)
            user.device.step(force)
            found[i].append(force)
    return np.array(found)


@pytest.mark.parametrize("schedule", [AT_ONCE, LIVE], ids=["at once", "live"])
def test_the_protocol_by_hand_gives_the_simulators_forces_bit_for_bit(scenario, schedule):
    traces = simulate_one(scenario, Conditions(schedule=schedule))
    by_hand = forces(scenario, schedule)
    for user, own in zip(traces.users, by_hand, strict=True):
        np.testing.assert_array_equal(user.f_applied[:, 0], own)
    assert np.abs(by_hand).max() > 0.5


@pytest.mark.parametrize(
    ("tick_s", "rate_drop", "expected"),
    [(0.001, 8, 4), (0.001, 4, 3), (0.001, 1, 0), (0.0005, 16, 8), (0.002, 8, 2)],
)
def test_the_answer_is_taken_4_ms_into_a_frame_or_at_its_last_tick(tick_s, rate_drop, expected):
    assert LIVE.answer_tick(tick_s=tick_s, rate_drop=rate_drop) == expected
    assert AT_ONCE.answer_tick(tick_s=tick_s, rate_drop=rate_drop) == 0


@pytest.mark.parametrize(
    ("tick_s", "period_ticks", "expected"), [(0.001, 8, 2), (0.001, 2, 0), (0.0005, 16, 4)]
)
def test_the_server_steps_2_ms_into_its_period(tick_s, period_ticks, expected):
    assert LIVE.server_tick(tick_s=tick_s, period_ticks=period_ticks) == expected
    assert FrameSchedule().server_tick(tick_s=tick_s, period_ticks=period_ticks) == 0


@pytest.mark.parametrize("controller", LIBRARY)
def test_the_content_of_a_packet_is_given_by_its_flag(controller):
    scenario = parse_scenario(
        {"name": "one", "duration_s": 1.0, "controller": controller, "users": 1}
    )
    user, server = UserEnd(scenario.users[0], scenario, epoch=1), ServerEnd(scenario)
    sent = user.start_frame(0, 0, DeviceSample())
    [answer], _ = server.tick(0, [[sent]])
    for packet in (sent, answer):
        assert bool(packet.flags & FLAG_DIRECT) is not LIBRARY[controller].waves
    other = "direct" if LIBRARY[controller].waves else "pmwvc"  # the control
    ignores = ServerEnd(
        parse_scenario({"name": "one", "duration_s": 1.0, "controller": other, "users": 1})
    )
    assert ignores.tick(0, [[sent]])[0] == [None]
    assert ignores.other_controller == 1
