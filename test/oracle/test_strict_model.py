# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The exact model of the strict channel is the simulator's, where its account does not bind, for
every rate and delay, once the clocks of the playouts have settled.

That takes ten times as long as what is compared. So two sessions show to which course the clocks
come by themselves; all others are given it.
"""

import dataclasses

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from oracle.test_multirate_model import compare
from support import linear_loops
from support.laws import alter_laws

from pmwvc_analysis.models import ends
from pmwvc_analysis.models.linearize import build
from pmwvc_analysis.models.links import hyperperiod_ticks, link_times
from pmwvc_analysis.models.matrices import made_once
from pmwvc_analysis.models.stability import radii
from pmwvc_analysis.models.variation import settled_pace
from pmwvc_analysis.prediction.lag import lag_s
from pmwvc_bringup import scenarios as files
from pmwvc_core.law.channel.pace import NEW
from pmwvc_core.law.channel.playout import add
from pmwvc_core.law.vectors import zero
from pmwvc_core.simulation.session import SteppedSession

AROUND = (
    {},
    {"velocity_filter__kind": "exact", "velocity_filter__cutoff_hz": 20.0},
    {"velocity_filter__kind": "equivalent", "velocity_filter__cutoff_hz": 90.0},
    {"bank__kind": "complementary", "bank__split_rad_s": 80.0},
)


STORE_S = 0.1  # more than a settled playout has in store


@pytest.fixture
def unbound(monkeypatch):
    """Give every playout energy for whatever it does, and time to play what it has in store."""
    names = ("channel__playout__free_j", "channel__arrivals__free_j")
    endless = dict.fromkeys(names, lambda playout: 1e9)
    alter_laws(monkeypatch, channel__playout__MOST_J=1e12, **endless)
    monkeypatch.setattr(linear_loops, "SETTLED", 800)


def paces_of(scenario):
    """Return the settled clocks of every user's playouts: at the server, at the device."""
    times = (link_times(user, scenario, live=False) for user in scenario.users)
    return [
        (settled_pace(up, scenario.tick_s), settled_pace(down, scenario.tick_s))
        for up, down, _ in times
    ]


def settled(scenario):
    """Return what gives the playouts of a session their settled clocks, and much in store, at the
    beginning of a hyperperiod in which all are there.
    """
    ticks, paces = hyperperiod_ticks(scenario), paces_of(scenario)

    def clocked(s, pace):
        playout = s.arrivals.playout
        stored = add(playout, zero(playout.undelivered), 0.0, STORE_S, 0.0)
        return s._replace(arrivals=s.arrivals._replace(playout=stored._replace(pace=pace)))

    def give(batch):
        batch.advance(-(-300 // ticks) * ticks * batch.tick_ns)
        guests = batch.server.s.guests
        pairs = zip(guests, paces, strict=True)
        guests = tuple(clocked(guest, up) for guest, (up, _) in pairs)
        batch.server.s = batch.server.s._replace(guests=guests)
        for user, (_, down) in zip(batch.users, paces, strict=True):
            user.loop.s = clocked(user.loop.s, down)

    return give


@st.composite
def scenarios(draw):
    values = {
        "channel": "strict",
        "master__rate_drop": draw(st.sampled_from([1, 3, 5, 8, 11])),
        "server__period_s": draw(st.sampled_from([0.002, 0.003, 0.007, 0.008])),
        "server__environment": draw(st.sampled_from(["cube", "wall"])),
        "user1__device__mass": draw(st.floats(0.2, 0.6)),
        "user2__device__damping": draw(st.floats(0.0, 3.0)),
        "user1__server__contact_stiffness": draw(st.floats(0.0, 900.0)),
        "link__up__delay_s": draw(st.sampled_from([0.0, 0.001, 0.0035, 0.016])),
        "link__down__delay_s": draw(st.sampled_from([0.0, 0.003, 0.008])),
    }
    around = draw(st.sampled_from(AROUND))
    return linear_loops.scenario(**values, **{f"master__{n}": v for n, v in around.items()})


@settings(max_examples=4, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(scenario=scenarios())
def test_model_and_simulator_agree_on_random_rates_and_delays(unbound, scenario):
    assert compare(scenario, model=build(scenario), before=settled(scenario)) < 1e-9


@pytest.mark.parametrize(
    "values",
    [
        {"master__rate_drop": 3, "server__period_s": 0.007, "link__delay_s": 0.016},
        {"master__rate_drop": 11, "server__period_s": 0.002, "link__up__delay_s": 0.0035},
    ],
)
def test_the_clocks_of_a_session_come_to_the_course_of_the_model(values):
    scenario = linear_loops.scenario(channel="strict", users=1, **values)
    ticks = hyperperiod_ticks(scenario)
    until = 12000 // ticks * ticks
    session = SteppedSession(dataclasses.replace(scenario, duration_s=12.0))
    session.advance(until * session.tick_ns)
    ends = session.server.s.guests[0], session.users[0].loop.s
    for end, expected in zip(ends, paces_of(scenario)[0], strict=True):
        found = end.arrivals.playout.pace
        for name in ("store_s", "silent_s", "shift_s", "ratio"):
            assert getattr(found, name) == pytest.approx(getattr(expected, name), abs=1e-8), name


def test_the_model_of_clocks_that_have_not_settled_does_not_agree(unbound, monkeypatch):
    """The control."""
    values = {"channel": "strict", "master__rate_drop": 5, "link__up__delay_s": 0.016, "users": 1}
    scenario = linear_loops.scenario(**values)
    before = settled(scenario)
    assert compare(scenario, model=build(scenario), before=before) < 1e-9
    monkeypatch.setattr(ends, "settled_pace", lambda way, tick_s: NEW)
    made_once.cache_clear()
    assert compare(scenario, model=build(scenario), before=before) > 1e-3


@pytest.mark.parametrize(("stiffness", "stable"), [(60.0, True), (120.0, False)])
def test_a_small_push_decays_or_grows_as_the_radius_says(stiffness, stable):
    scenario = linear_loops.scenario(
        channel="strict",
        master__rate_drop=3,
        users=1,
        link__delay_s=0.016,
        server__environment="wall",
        server__coupling="one_frame_late",
        server__contact_damping=1.0,
        server__contact_stiffness=stiffness,
    )
    radius = float(radii(scenario)[0])
    assert (radius < 1.0) is stable
    push = np.zeros((1, 12800))
    push[0, 700:800] = 1e-6  # once the clocks have settled
    traces = linear_loops.simulated(scenario, push, before=settled(scenario))
    speed = traces.users[0].xd_m[-12000:, 0].reshape(4, -1)
    seen = np.diff(np.log(np.linalg.norm(speed[::3], axis=1)))[0] / 9.0  # per second
    assert seen == pytest.approx(np.log(radius) / 0.024, abs=0.02)


def test_the_model_of_the_plain_channel_does_not_agree(unbound):
    """The control."""
    scenario = linear_loops.scenario(channel="strict", link__delay_s=0.016)
    other = build(linear_loops.scenario(channel="plain", link__delay_s=0.016))
    assert compare(scenario, model=other, before=settled(scenario)) > 1e-3


def test_strict_renders_no_softer_than_plain_at_any_constant_delay():
    """By the lags, which ``test_rendered_stiffness.py`` holds against the exact model."""
    for delay_s in (0.0, 0.008, 0.016, 0.06):
        lags_s = {}
        for channel in ("plain", "strict"):
            texts = [f"channel={channel}", f"link.delay_s={delay_s}"]
            scenario = files.load("carry_16ms", settings_texts=texts)
            lags_s[channel] = lag_s(scenario.users[0], scenario, live=False)
        assert lags_s["strict"] <= lags_s["plain"] * (1.0 + 1e-12)
