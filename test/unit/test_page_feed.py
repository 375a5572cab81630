# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The feed of a page: traces of several nodes on one grid, and the energy accounts of them."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.plain import load
from support.simulated import judged, simulated

from pmwvc_analysis.budget.energy import user_energies
from pmwvc_view.feed.feed import PATIENCE_NS, Feed
from pmwvc_view.feed.tape import F_APPLIED, KEPT, TraceBlock, TraceStep
from pmwvc_view.feed.verdict import Judge, verdict
from pmwvc_view.protocol.snapshot import Layout
from pmwvc_view.recorded import RecordedSession
from pmwvc_view.simulated import Simulation

USERS = ("user1", "user2")
MS = 1_000_000
PERIOD_S = 0.016
LIVE = load("live")


def block(start_ms, forces, **changes):
    """Return a block of a master whose position is its time."""
    count = len(forces)
    times = (start_ms + np.arange(float(count))).reshape(-1, 1)
    signals = np.zeros((len(KEPT), count, 1))
    signals[KEPT.index("x_m")] = times
    signals[F_APPLIED, :, 0] = forces
    made = TraceBlock(
        start_ns=start_ms * MS,
        period_ns=MS,
        signals=signals,
        lateness_s=[1e-5] * count,
        state=1,
        reason="",
        missed=0,
        epoch=1,
        sums=None,
    )
    return made._replace(**changes)


def step(at_ms, users=2):
    place, each = np.full((3, 1), float(at_ms)), np.full((3, users, 1), float(at_ms))
    sums = np.zeros((2, users))
    return TraceStep(at_ms * MS, 1, place, each, [2] * users, [True] * users, 0.0, sums)


def feed_of(users=USERS, scenario=LIVE):
    layout = Layout(users, 1)
    return layout, Feed(layout, scenario, period_ns=16 * MS)


def told(feed, *, exact_hands=USERS):
    """Return the text message of now."""
    judge = Judge(feed.tape)
    return verdict(feed.users, judge, storage_j={}, exact_hands=exact_hands, notices=[])


def values(layout, snapshots, name):
    return [float(each.row[layout.slices[name]][0]) for each in snapshots]


def test_row_holds_the_newest_tick_and_step_at_its_time_and_the_extremes_since_the_last():
    layout, feed = feed_of(("user1",))
    forces = np.sin(np.arange(48.0))
    for start in range(0, 48, 8):
        feed.on_master("user1", block(start, forces[start : start + 8]))
        feed.on_server(step(start + 2, users=1))
    rows = feed.rows(48 * MS)
    assert values(layout, rows, "seq") == [1.0, 2.0]
    assert values(layout, rows, "time_s") == [0.016, 0.032]
    assert values(layout, rows, "user1.x_m") == [16.0, 32.0]
    assert values(layout, rows, "user1.x_s") == [10.0, 26.0]
    assert values(layout, rows, "user1.f_applied") == [forces[16], forces[32]]
    assert values(layout, rows, "user1.f_max") == [forces[:17].max(), forces[17:33].max()]
    assert values(layout, rows, "user1.f_min") == [forces[:17].min(), forces[17:33].min()]


@settings(max_examples=30)
@given(st.permutations(range(3)), st.integers(1, 5))
def test_rows_do_not_depend_on_whose_trace_comes_first(order, together):
    def run(turns):
        _, feed = feed_of()
        queues = [
            [
                lambda s=s, u=u: feed.on_master(u, block(s, np.arange(s, s + 8.0)))
                for s in range(0, 96, 8)
            ]
            for u in USERS
        ] + [[lambda s=s: feed.on_server(step(s)) for s in range(0, 96, 8)]]
        for first in range(0, 12, together):
            for who in turns:
                for act in queues[who][first : first + together]:
                    act()
        return np.array([each.row for each in feed.rows(96 * MS)])

    np.testing.assert_array_equal(run(order), run((0, 1, 2)))


def test_silent_node_holds_rows_up_for_a_moment_only():
    layout, feed = feed_of()
    for start in range(0, 200, 8):
        feed.on_master("user1", block(start, np.ones(8)))
        feed.on_server(step(start))
    assert feed.rows(100 * MS)[:1] != [] and len(feed.rows(100 * MS)) == 0
    late = feed.rows(48 * MS + PATIENCE_NS + 60 * MS)
    assert late and np.isnan(values(layout, late, "user2.x_m")).all()
    assert values(layout, late, "user1.x_m")[-1] > 0.0


def test_ticks_that_came_after_their_row_are_in_the_extremes_of_the_next_one():
    """A loop that stalled sends its trace late: its lateness must be seen."""
    layout, feed = feed_of()
    feed.on_master("user2", block(0, np.ones(8)))
    for start in range(0, 200, 8):
        feed.on_master("user1", block(start, np.ones(8)))
        feed.on_server(step(start))
    early = feed.rows(200 * MS)
    assert len(early) > 2 and np.nanmax(values(layout, early, "user2.f_max")) == 1.0
    feed.on_master("user2", block(8, [1.0, 5.0] * 4, lateness_s=[0.09] * 8))
    feed.on_master("user2", block(16, np.ones(184)))
    late = feed.rows(260 * MS)
    assert values(layout, late, "user2.f_max")[0] == 5.0
    assert values(layout, late, "user2.lateness")[0] == 0.09


def test_user_whose_traces_stop_is_no_longer_shown_as_coupled():
    layout, feed = feed_of()
    rows = []
    feed.on_master("user2", block(0, np.ones(8)))  # no row shows it yet
    assert "any more" not in told(feed)["verdict"]
    for start in range(0, 1200, 8):
        for user in USERS[: 1 if start >= 400 else 2]:
            feed.on_master(user, block(start, np.ones(8)))
        feed.on_server(step(start))
        rows += feed.rows((start + 8) * MS)
    places = np.array(values(layout, rows, "user2.x_m"))
    times = np.array(values(layout, rows, "time_s"))
    assert np.isfinite(places[times < 0.9]).all() and np.isnan(places[times > 0.92]).all()
    found = told(feed)
    assert found["verdict"] == "Not all users are coupled: user2 sends nothing any more."
    assert found["users"]["user2"]["state"] == "no data"
    for user in USERS:
        feed.on_master(user, block(1200, np.ones(16)))
    feed.on_server(step(1216))
    feed.rows(1300 * MS)
    assert feed.users["user2"].state == 1


@pytest.mark.parametrize("again", [None, "master", "server", "user"])
def test_energy_of_counters_that_began_anew_is_no_longer_judged(again):
    """A node was started again, or its user came back to the server."""
    _, feed = feed_of(("user1",))
    for start in range(0, 400, 8):
        late = again is not None and start >= 200
        moved = 1e-3 * (start - 200 * late)
        own, others = (2 if late and again == node else 1 for node in ("master", "server"))
        sums = (moved if again == "master" else 1e-3 * start, 0.0, 1e-3 * start)
        feed.on_master("user1", block(start, np.ones(8), epoch=own, sums=sums))
        u_s = 0.5 * (moved if again == "user" else 1e-3 * start)
        made = step(start, users=1)._replace(epoch=others, sums=np.array([[u_s], [0.0]]))
        feed.on_server(made)
        feed.rows((start + 8) * MS)
    balances = feed.users["user1"].balances
    assert balances.known and balances.judged == (again is None)
    assert balances.worst["way up"].margin_j >= 0.0


def run_live(scenario, ticks, poll=16):
    """Return feed and rows of a scenario that is simulated as for a page."""
    layout = Layout([user.name for user in scenario.users], scenario.dof)
    feed, rows = Feed(layout, scenario, period_ns=poll * MS), []
    simulation = Simulation(scenario, feed, epoch=1)
    for tick in range(poll, ticks + 1, poll):
        simulation.run(tick)
        rows += feed.rows(tick * MS)
    return layout, feed, rows


@pytest.fixture(scope="module")
def carried():
    """A simulated session three ways: traces, and as a page sees it live and recorded."""
    scenario = replace(load("carry_16ms"), duration_s=6.0)
    return scenario, simulated(scenario), run_live(scenario, 6000)


def test_page_shows_the_session_that_the_simulator_gives(carried):
    _, traces, (layout, _, rows) = carried
    user, server = traces.users[0], traces.server
    for row in (each.row for each in rows):
        tick = round(float(row[1]) * 1e3)
        assert row[layout.slices["user1.x_m"]] == user.x_m[tick]
        assert row[layout.slices["object.x_o"]] == server.x_o[tick // 8]
        assert row[layout.slices["user1.f_applied"]] == user.f_applied[tick]


def test_page_of_eight_users_on_three_axes_knows_all_of_them():
    scenario = load("cube_3d", users=8, duration_s=2.0)
    layout, feed, rows = run_live(scenario, 800)
    row = rows[-1].row
    for user in scenario.users:
        assert row[layout.slices[f"{user.name}.x_m"]].shape == (3,)
        assert feed.users[user.name].state == 1
        assert np.isfinite(row[layout.slices[f"{user.name}.energy_up_in"]]).all()
    links = np.concatenate([each.packets for each in rows])[:, 0]
    assert set(links.tolist()) == set(range(16))


def test_recorded_rows_are_those_of_the_live_page(carried):
    scenario, traces, (layout, _, rows) = carried
    whole = RecordedSession(traces, scenario, judged(scenario), snapshot_s=PERIOD_S)
    again, recorded = whole.rows, whole.packets
    for name in ("user1.x_m", "user2.f_applied", "user1.f_max", "user2.x_s", "object.x_o"):
        at = layout.slices[name]
        for row in (each.row for each in rows[1:]):
            index = round(float(row[1]) / PERIOD_S)
            assert again[index, at] == pytest.approx(row[at], abs=1e-12), (name, row[1])
    live = np.concatenate([each.packets for each in rows])
    both = {tuple(each) for each in np.round(live, 6)} & {tuple(e) for e in np.round(recorded, 6)}
    assert len(both) > 0.98 * len(recorded)


LOSSY = ("channel=strict", "link.loss=0.1", "link.jitter=uniform", "link.jitter_s=0.012")


@pytest.mark.parametrize("texts", [(), LOSSY, (*LOSSY, "master.position.gain=2.0")])
def test_page_has_the_reports_balances_at_every_block(texts):
    """The report knows a block's v_m and work a step later, and what packets were paid with."""
    scenario = load("carry_16ms", settings_texts=texts, duration_s=2.0)
    traces = simulated(scenario)
    _, feed, _ = run_live(scenario, 1984, poll=8)
    for energy in user_energies(traces, scenario):
        balances = feed.users[energy.name].balances
        shown, reported = balances.table.rows, (energy.up, energy.down, energy.joint)
        steps = (np.rint(1e3 * shown[:, 0]).astype(int) - 7) // 8
        assert len(steps) > 240
        for way, balance in enumerate(reported):
            came, went, _ = shown[:, 1 + 3 * way : 4 + 3 * way].T
            if balance is None:  # position feedback alters the wave at the device
                assert len(texts) > len(LOSSY) and way == 1 and np.isnan(came).all()
                continue
            late_in, late_out = ((0 if texts else 1, 0), (0, 1), (1, 0))[way]
            np.testing.assert_allclose(came, balance.energy_in_j[steps + late_in], rtol=1e-12)
            np.testing.assert_allclose(went, balance.energy_out_j[steps + late_out], rtol=1e-12)
        assert all(worst.margin_j >= 0.0 for worst in balances.worst.values())


def test_balance_of_counters_read_at_two_instants_would_be_below_zero(carried):
    _, traces, _ = carried
    user, server = traces.users[0], traces.server
    naive = user.energy["u_m"][:-8] - server.energy_u_s[0][8 : len(user.energy["u_m"])]
    assert naive.min() < -1e-4


def test_channel_without_waves_that_shakes_is_not_passive_and_said_to_be():
    _, feed, _ = run_live(load("direct_16ms"), 8000)
    found = told(feed)
    assert found["level"] == "bad" and found["verdict"].startswith("Not passive: user1, hand to")
    assert feed.users["user1"].balances.worst["hand to object"].balance_j < -1e-3


def test_verdict_is_good_only_with_every_user_coupled_and_judged(carried):
    _, _, (_, feed, _) = carried
    assert told(feed)["level"] == "good"
    unknown = told(feed, exact_hands=["user1"])  # the true motion of the other is not known
    assert unknown["level"] == "unknown"
    assert "Energy at the hand is not judged here for user2" in unknown["verdict"]
    assert told(feed_of()[1])["level"] == "caution"


@pytest.mark.parametrize(
    ("texts", "why"),
    [
        ([], "it joined with the device inside the object, and slides to it once there is room"),
        (["controller=direct"], "this controller keeps the distance"),
        (["server.coupling=unknown"], "an environment known by its forces only has no face"),
    ],
)
def test_avatar_that_joined_elsewhere_is_noted_until_it_is_with_its_device(texts, why):
    layout, feed = feed_of(("user1",), load("wall", settings_texts=texts))
    notes = []
    for start, place_m in ((0, 0.012), (16, 0.010), (32, 0.001), (48, 0.02)):
        feed.on_master("user1", block(start, [0.0] * 16, signals=np.zeros((len(KEPT), 16, 1))))
        feed.on_server(step(start, users=1)._replace(avatars=np.full((3, 1, 1), place_m)))
        feed.others = {"user1.lag": 0.04, "user1.impedance": 25.0}
        rows = feed.rows((start + 16) * MS)
        notes.append(told(feed)["users"]["user1"]["note"])
        if rows:
            apart = "since joining" in notes[-1]
            assert np.isnan(values(layout, rows, "user1.lag")[-1]) == apart  # no F tau/(2b) then
    noted = [note for note in notes if "mm from the device since joining" in note]
    assert noted
    assert all(why in note for note in noted)
    assert "12.0 mm" in noted[0] or "10.0 mm" in noted[0]
    assert "since joining" not in notes[-1]  # 20 mm of a moving hand later are no such distance
