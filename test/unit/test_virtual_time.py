# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Sessions in virtual time: the order of ticks as a session ran, results in the order
asked for.
"""

from dataclasses import replace

import numpy as np
import pytest

from pmwvc_bringup import scenarios
from pmwvc_core.master.safety import SafetyState
from pmwvc_core.network.link import Link
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.simulation.conditions import Conditions
from pmwvc_core.simulation.session import NEVER_NS, SteppedSession, simulate, simulate_one
from pmwvc_core.transport.packet import size_bytes

MS = 1_000_000
TICKS = 16


def ran(*settings, ran_ns=None, first=0, **conditions):
    """Return what happened, in order: time [ns], what, whose, tick."""
    texts = ["users=2", "channel=plain", *settings]
    scenario = scenarios.load("carry_16ms", settings_texts=texts)
    name = scenario.users[0].name
    if ran_ns is not None:
        conditions |= {"ran_ns": {name: np.asarray(ran_ns)}}
    seen = []
    time = SteppedSession(
        replace(scenario, duration_s=TICKS * scenario.tick_s),
        Conditions(first={name: first}, **conditions),
    )
    time._note_step = lambda tick, now_ns, row: seen.append((now_ns, "SERVE", 0, tick))
    for who, user in enumerate(time.users):
        noted(user, who, seen)
    time.advance(NEVER_NS)
    return seen


def noted(user, who, seen):
    """Note what a user sends and runs."""
    step, send, passing = user.loop.tick, user.up.send, user.ticks.passing

    def tick(number, now_ns, sample, packets):
        seen.append((now_ns, "TICK", who, number + user.ticks.first))
        return step(number, now_ns, sample, packets)

    def sent(packet, now_ns):
        seen.append((now_ns, "SEND", who, user.ticks.ran[user.ticks.next]))
        send(packet, now_ns)

    def passed(most):
        for number in passing(most):
            seen.append((user.ticks.at_ns[user.ticks.next], "PASS", who, number))
            yield number

    user.loop.tick, user.up.send, user.ticks.passing = tick, sent, passed


def of(rows, what, who=0):
    return [(time, tick) for time, kind, whose, tick in rows if (kind, whose) == (what, who)]


def test_a_missed_tick_passes_when_the_loop_runs_again():
    times = np.arange(TICKS) * MS
    times[6:10] = -1  # the end of one frame and the start of the next
    rows = ran(ran_ns=times)
    assert of(rows, "PASS") == [(10 * MS, k) for k in range(6, 10)]
    assert [tick for _, tick in of(rows, "SEND")] == [0, 10]
    at_ten = [kind for time, kind, who, _ in rows if (time, who) == (10 * MS, 0)]
    assert at_ten == [*["PASS"] * 4, "SEND", "TICK"]


@pytest.mark.parametrize("first", [-40, 0, 4])
def test_a_loop_may_have_begun_before_the_session(first):
    """Of a recording that begins in its midst."""
    rows = ran(ran_ns=np.arange(TICKS) * MS, first=first)
    assert [tick for _, tick in of(rows, "TICK")] == list(range(max(first, 0), TICKS))


def test_a_device_stands_still_beyond_a_tenth_of_a_second_as_a_live_one_does():
    ten_ms = ("master.tick_s=0.01", "server.period_s=0.08", "operator.kind=none")
    times = np.arange(TICKS) * 10 * MS
    times[2:14] = -1
    rows = ran(*ten_ms, ran_ns=times)
    assert of(rows, "PASS") == [(140 * MS, k) for k in range(2, 11)]


@pytest.mark.parametrize("channel", ["plain", "strict"])
def test_a_packet_is_taken_at_the_tick_at_which_it_comes(channel):
    texts = [f"channel={channel}", "link.delay_s=0.003"]
    traces = simulate_one(scenarios.load("carry_16ms", settings_texts=texts, duration_s=0.5))
    came = traces.packets["/user1/wave_down"]
    on_way_s = came.time_s - came.sent_ns * 1e-9
    np.testing.assert_allclose(on_way_s, 0.003, atol=1e-9)


@pytest.mark.parametrize("channel", ["plain", "strict"])
def test_frames_longer_than_the_time_of_silence_leave_users_coupled(channel):
    texts = [f"channel={channel}", "master.rate_drop=50"]
    scenario = scenarios.load("carry_16ms", settings_texts=texts, duration_s=3.0)
    assert scenario.users[0].safety.timeout_s < scenario.users[0].master.frame_s
    for user in simulate_one(scenario).users:
        assert (user.state[user.block_time_s > 1.0] == SafetyState.COUPLED).all()


SHORT = {
    "name": "short",
    "duration_s": 1.5,
    "controller": "pmwvc",
    "channel": "plain",
    "users": 2,
    "task": {"kind": "hold", "grip_s": 0.1, "grip_rise_s": 0.2},
}


def test_results_come_in_the_order_asked_for_whatever_the_batches():
    scenarios = [
        parse_scenario(SHORT | {"duration_s": duration}, overrides={"server.object_mass": mass})
        for duration, mass in ((0.2, 1.0), (0.1, 1.0), (0.2, 2.0), (0.1, 2.0))
    ]
    shares = []
    kept = simulate(scenarios, keep=lambda traces, _: traces.duration_s, progress=shares.append)
    assert kept == [0.2, 0.1, 0.2, 0.1]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


def test_the_links_of_a_session_have_the_fates_of_the_link_alone():
    scenario = parse_scenario(SHORT | {"link": {"loss": 0.2, "duplicate": 0.1, "delay_s": 0.005}})
    seen = simulate_one(scenario).fates["user2/down"]
    link = Link(scenario.users[1].link_down, seed=(scenario.seed, 1, 1))
    times = seen.time_in_ns[seen.fate != 2]
    alone = [f for time in times for f in link.send(None, int(time), size_bytes=size_bytes(1))]
    assert [int(fate.kind) for fate in alone] == seen.fate.tolist()
    assert {0, 1, 2} == set(seen.fate.tolist())
