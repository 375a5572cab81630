# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Outages in the middle of a carry, on the strict channel: damping, then together again."""

from dataclasses import replace

import numpy as np
import pytest
from support.laws import alter_laws
from support.simulated import late_s, least_j, simulated

from pmwvc_analysis.budget.budget import budget
from pmwvc_analysis.budget.energy import user_energies
from pmwvc_analysis.events.nodes import limited
from pmwvc_bringup import scenarios as files
from pmwvc_core.frame import LIVE, Presence
from pmwvc_core.law.channel.constants import HOLD_S, REPORTED_S
from pmwvc_core.law.channel.pace import pace_arrive
from pmwvc_core.law.port.strict_master import KEPT_J
from pmwvc_core.master.safety import BRAKING, SafetyState
from pmwvc_core.network.in_flight import RecordedFate, RecordedLink
from pmwvc_core.params import SafetyParams
from pmwvc_core.simulation.conditions import Conditions, Steps
from pmwvc_core.simulation.session import SteppedSession, simulate_one

SPARED = ("channel__arrivals__spared", "port__strict_master__spared")
BEGIN_S, LEAST_J = 3.0, -1e-9
DELAY_S, STEP_S = 0.016, 0.008
ROUND_TRIP_S = 2 * (DELAY_S + STEP_S)
# The end that is told is the later one; a wave is on its way, and loops look once in a step.
BRAKED_S = 2 * DELAY_S + REPORTED_S + SafetyParams().timeout_s + 3 * STEP_S
OUTAGES = {
    "up": ("link.up", 0.5),
    "down": ("link.down", 0.5),
    "short": ("link", 0.05),
    "long": ("link", 2.0),
}


def session(link="", length_s=0.0, *, channel="strict"):
    duration_s = BEGIN_S + length_s + 2.0
    texts = [f"channel={channel}"]
    if link:
        texts.append(f"{link}.schedule={BEGIN_S} outage; {BEGIN_S + length_s} base")
    scenario = files.load("carry_16ms", settings_texts=texts, duration_s=duration_s)
    return scenario, simulated(scenario)


def apart_m(traces, since_s, until_s):
    """Largest distance of a device from its avatar [m]."""
    server = traces.server
    rows = (server.time_s >= since_s) & (server.time_s < until_s)
    return max(
        np.abs(np.interp(server.time_s[rows], user.time_s, user.x_m[:, 0]) - x_s[rows, 0]).max()
        for user, x_s in zip(traces.users, server.x_s, strict=True)
    )


def peak_n(traces):
    return max(np.abs(user.f_applied[user.time_s > 2.0]).max() for user in traces.users)


def brakes_in_time(time_s, state, damping, length_s):
    """Tell whether a force loop, or an avatar, has only damping soon after the begin of an outage;
    one that is concealed brakes neither.
    """
    rows = (time_s >= BEGIN_S) & (np.ravel(state) == damping)
    if length_s < HOLD_S - STEP_S:
        return not rows.any()
    return time_s[rows][0] - BEGIN_S <= BRAKED_S


@pytest.mark.parametrize("name", OUTAGES)
def test_hands_and_cube_are_together_within_a_second(name):
    link, length_s = OUTAGES[name]
    end_s = BEGIN_S + length_s
    scenario, traces = session(link, length_s)
    _, calm = session()
    for user, energy in zip(traces.users, user_energies(traces, scenario), strict=True):
        assert least_j(energy) >= LEAST_J
        most = user.tick_s * scenario.users[0].safety.max_slew
        assert np.abs(np.diff(user.f_applied[:, 0])).max() <= most * (1.0 + 1e-9)
        assert brakes_in_time(user.block_time_s, user.state, SafetyState.DAMPING, length_s)
        assert np.abs(user.f_applied[-500:]).mean() > 1.0  # the grip is there
    for state in traces.server.state:
        assert brakes_in_time(traces.server.time_s, state, Presence.DAMPING, length_s)
    force = max(np.abs(user.f_applied[-1, 0]) for user in traces.users)
    allowed_m = force * ROUND_TRIP_S / (2.0 * 25.0) + 1e-3
    assert apart_m(traces, end_s + 1.0, end_s + 2.0) <= allowed_m
    assert peak_n(traces) <= 1.5 * peak_n(calm)


def test_without_a_brake_the_hands_close_in_and_stay_apart():
    """The control: the plain channel, under the same outage."""
    _, traces = session(*OUTAGES["up"], channel="plain")
    assert apart_m(traces, BEGIN_S + 1.5, BEGIN_S + 2.5) > 10e-3


def test_a_link_dead_one_way_brakes_both_ends_and_is_named():
    _, traces = session(*OUTAGES["up"])
    at_s = BEGIN_S + 0.3
    for user, state, grip in zip(
        traces.users, traces.server.state, traces.server.f_s, strict=True
    ):
        rows = (user.block_time_s > BEGIN_S) & (user.block_time_s < BEGIN_S + 0.6)
        reasons = {text for text, row in zip(user.reason, rows, strict=True) if row}
        assert "server receives nothing from this user: damping only" in reasons
        assert not any("server silent" in text for text in reasons)
        at = int(at_s / traces.server.period_s)
        assert state[at] == Presence.DAMPING
        assert np.abs(user.f_applied[int(at_s * 1000), 0]) < 2.5
        assert np.abs(grip[at, 0]) > 1.0  # the avatars hold the cube


def test_what_a_brake_holds_is_not_paid_to_packets_and_is_no_limit():
    texts = ["channel=strict", "link.schedule=4 outage; 6 base"]
    traces = simulated(files.load("blackout_2s", settings_texts=texts, duration_s=6.5))
    for user in traces.users:
        assert user.accounts["node"].min() >= LEAST_J  # the hand takes 0.5 mJ of it back
        beside = np.abs(user.f_applied - user.f_m)[user.time_s > 2.0]
        assert BRAKING in user.reason and beside.max() > 0.1  # [N] of the brake
        ((_, _, ticks, *_),) = limited(user, None)
        assert not ticks[user.time_s > 2.0].any()


STALL_S, STALLED = 4.0, {"user1": 0.3, "server": 1.0, "links": 0.5}
BURST_S = 0.02  # in which links give out what they kept back


def burst():
    """Return a link that keeps everything back for a while, then gives it out in quick order."""
    record, end_s = {}, STALL_S + STALLED["links"]
    for number in range(1, 1025):
        sent_s = (number - 1) * 0.008
        out_s = sent_s + 0.016
        if STALL_S <= out_s < end_s:
            out_s = end_s + BURST_S * (out_s - STALL_S) / STALLED["links"]
        record[number] = (RecordedFate(round((out_s - sent_s) * 1e9)),)
    return RecordedLink(record)


def stalled(who, duration_s=7.0):
    """Two hands carry; the loop of one process stands still and skips what was due, or all links
    keep everything back.
    """
    scenario = files.load("blackout_2s", settings_texts=["link.schedule="], duration_s=duration_s)
    end_s = STALL_S + STALLED[who]
    ticks = np.arange(round(duration_s * 1000), dtype=np.int64)
    still = (ticks >= STALL_S * 1000) & (ticks < end_s * 1000)
    if who == "server":
        steps = ticks[(ticks % 8 == 2) & ~still]
        every = Steps(steps, steps * 1_000_000, np.full(len(steps), scenario.server.period_s))
        conditions = Conditions(schedule=LIVE, steps=every)
    elif who == "links":
        names = [f"user{user}/{way}" for user in (1, 2) for way in ("up", "down")]
        conditions = Conditions(schedule=LIVE, links=dict.fromkeys(names, burst))
    else:
        ran_ns = {who: np.where(still, -1, ticks * 1_000_000)}
        conditions = Conditions(schedule=LIVE, ran_ns=ran_ns)
    return scenario, simulate_one(scenario, conditions)


@pytest.mark.parametrize("who", STALLED)
def test_what_stood_still_makes_nothing_later(who):
    scenario, traces = stalled(who)
    before_m = apart_m(traces, 3.0, STALL_S)
    assert apart_m(traces, STALL_S + STALLED[who] + 1.2, 7.0) < before_m + 1e-3
    for user, energy in zip(traces.users, user_energies(traces, scenario), strict=True):
        assert least_j(energy) >= LEAST_J
        limit = scenario.users[0].safety.max_slew * scenario.tick_s
        assert np.abs(np.diff(user.f_applied[:, 0])).max() <= limit * (1.0 + 1e-9)


def test_what_is_played_later_leaves_them_apart(monkeypatch):
    """The control: no loop lets time go by, no burst is skipped, no lag is made up. In motion the
    lag of one hand alone shows less: it is carried from 4 to 7 s.
    """
    alter_laws(
        monkeypatch,
        channel__arrivals__pass_by=lambda playout, lasted_s: playout,
        channel__playout__pace_arrive=lambda pace, lasted_s: pace_arrive(pace, lasted_s)._replace(
            shift_s=pace.shift_s, burst_s=0.0
        ),
    )
    _, traces = stalled("links", duration_s=8.0)
    assert apart_m(traces, 7.5, 8.0) > 5e-3


def test_what_a_playout_passes_on_beside_its_wave_is_the_nodes():
    texts = ["task.move_s=2.5", "link.schedule=3.5 outage; 5.5 base"]
    scenario = files.load("carry_16ms", settings_texts=texts, duration_s=9.0)
    traces = simulated(scenario)
    user = traces.users[0]
    passed_j = user.accounts["playout_released"]
    assert passed_j[-1] > 1e-4  # after the outage
    found = budget(traces, scenario)
    assert found.closes
    assert found.released == []
    node = found.parts["user1"]["node"][found.time_s > 8.0]
    assert node == pytest.approx(KEPT_J, abs=2e-5)
    (entry,) = [each for each in user_energies(traces, scenario) if each.name == "user1"]
    assert least_j(entry) >= LEAST_J
    unknown = {name: sums for name, sums in user.accounts.items() if name != "playout_released"}
    blind = replace(traces, users=[replace(user, accounts=unknown), traces.users[1]])
    alone = budget(blind, scenario).parts["user1"]["node"][found.time_s > 8.0]
    assert alone + passed_j[-1] == pytest.approx(node, abs=1e-9)  # the control


LASTED = {  # from 3 to 6 s
    "losses in bursts": "link.schedule=3 ge_p=0.0833 ge_r=0.333; 6 base",
    "a delay of 200 ms": "link.schedule=3 delay_s=0.2; 6 base",
}


def left(name, *settings, after_s=6.0):
    """So long after a disturbance: time from port to port, T1 + T2 of the later user [s], and
    distance from device to avatar that is still undelivered, in both directions [m].
    """
    texts = ["channel=strict", LASTED[name], *settings]
    scenario = files.load("carry_16ms", settings_texts=texts, duration_s=6.0 + after_s)
    batch = SteppedSession(scenario)
    batch.run(lambda _: None)
    ends = [*batch.server.s.guests, *(user.loop.s for user in batch.users)]
    undelivered = max(abs(each.arrivals.playout.undelivered[0]) for each in ends)
    return max(late_s(batch, user) for user in (0, 1)), undelivered / np.sqrt(2.0 * 25.0)


@pytest.mark.parametrize("name", LASTED)
def test_the_lag_is_back_six_seconds_after_a_disturbance(name):
    late_s, undelivered_m = left(name)
    assert late_s <= ROUND_TRIP_S + 0.015 and undelivered_m < 1e-4


def test_where_neither_direction_nor_hand_pays_a_distance_stays(monkeypatch):
    """The control. Nor does E0 pay."""
    none = {name: lambda s, h, wanted, beyond_j, p: (s, 0.0) for name in SPARED}
    alter_laws(monkeypatch, port__strict_master__ASKED=0.0, **none)
    unlent = "master.store_j=0", "server.store_j=0"
    assert left("losses in bursts", *unlent, after_s=3.0)[1] > 5e-4
