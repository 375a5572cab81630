# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The feed of a page: traces of several nodes on one grid, and the energy accounts of them."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.plain import load
from support.simulated import simulated

from pmwvc_analysis.budget.energy import user_energies
from pmwvc_view.feed.feed import PATIENCE_NS, Feed
from pmwvc_view.feed.traces import F_APPLIED, SIGNALS, TraceBlock, TraceStep
from pmwvc_view.feed.verdict import verdict
from pmwvc_view.protocol.snapshot import Layout
from pmwvc_view.recorded.rows import packets_of, rows_of
from pmwvc_view.simulated import Simulation

USERS = ("user1", "user2")
MS = 1_000_000
PERIOD_S = 0.016


def block(start_ms, forces, **changes):
    """Return a block of a master whose position is its time."""
    count = len(forces)
    times = (start_ms + np.arange(float(count))).reshape(-1, 1)
    signals = np.zeros((len(SIGNALS), count, 1))
    signals[SIGNALS.index("x_m")] = times
    signals[F_APPLIED, :, 0] = forces
    made = TraceBlock(
        start_ns=start_ms * MS,
        period_ns=MS,
        signals=signals,
        lateness_s=[1e-5] * count,
        state=1,
        reason="",
        missed=0,
        sums=None,
    )
    return made._replace(**changes)


def step(at_ms, users=2):
    place, each = np.full((3, 1), float(at_ms)), np.full((3, users, 1), float(at_ms))
    return TraceStep(at_ms * MS, place, each, [2] * users, [True] * users, 0.0, {})


def feed_of(users=USERS):
    layout = Layout(users, 1)
    return layout, Feed(layout, users, period_ns=16 * MS)


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


def test_user_whose_traces_stop_is_no_longer_shown_as_coupled():
    layout, feed = feed_of()
    rows = []
    words = lambda: verdict(feed, USERS, storage_j={}, exact_hands=USERS, notices=[])  # noqa: E731
    feed.on_master("user2", block(0, np.ones(8)))  # no row shows it yet
    assert "any more" not in words()["verdict"]
    for start in range(0, 1200, 8):
        for user in USERS[: 1 if start >= 400 else 2]:
            feed.on_master(user, block(start, np.ones(8)))
        feed.on_server(step(start))
        rows += feed.rows((start + 8) * MS)
    places = np.array(values(layout, rows, "user2.x_m"))
    times = np.array(values(layout, rows, "time_s"))
    assert np.isfinite(places[times < 0.9]).all() and np.isnan(places[times > 0.92]).all()
    found = words()
    assert found["verdict"] == "Not all users are coupled: user2 sends nothing any more."
    assert found["users"]["user2"]["state"] == "no data"
    feed.on_master("user2", block(1200, np.ones(8)))
    feed.on_master("user1", block(1200, np.ones(8)))
    feed.on_server(step(1200))
    feed.rows(1300 * MS)
    assert feed.user("user2").state == 1


def run_live(scenario, ticks, period_ns=16 * MS):
    """Return feed and rows of a scenario that is simulated as for a page."""
    names = [user.name for user in scenario.users]
    layout = Layout(names, scenario.dof)
    feed = Feed(layout, names, period_ns=period_ns)
    simulation = Simulation(scenario, feed, epoch=1)
    simulation.run(ticks)
    return layout, feed, feed.rows(ticks * MS)


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
        assert feed.user(user.name).state == 1
        assert np.isfinite(row[layout.slices[f"{user.name}.energy_up_in"]]).all()
    links = np.concatenate([each.packets for each in rows])[:, 0]
    assert set(links.tolist()) == set(range(16))


def test_recorded_rows_are_those_of_the_live_page(carried):
    scenario, traces, (layout, _, rows) = carried
    again = rows_of(traces, scenario, layout, period_s=PERIOD_S)
    for name in ("user1.x_m", "user2.f_applied", "user1.f_max", "user2.x_s", "object.x_o"):
        at = layout.slices[name]
        for row in (each.row for each in rows[1:]):
            index = round(float(row[1]) / PERIOD_S)
            assert again[index, at] == pytest.approx(row[at], abs=1e-12), (name, row[1])
    live = np.concatenate([each.packets for each in rows])
    recorded = packets_of(traces, scenario)
    both = {tuple(each) for each in np.round(live, 6)} & {tuple(e) for e in np.round(recorded, 6)}
    assert len(both) > 0.98 * len(recorded)


def test_account_of_a_page_is_that_of_the_report(carried):
    scenario, traces, (_, feed, _) = carried
    for energy in user_energies(traces, scenario):
        accounts = feed.user(energy.name).accounts
        up, down, hand = accounts.up, accounts.down, accounts.hand
        # The last block that is known ended before the last step; the report is at that step.
        assert up.in_j == pytest.approx(energy.up.energy_in_j[-1], rel=1e-9)
        assert up.out_j == pytest.approx(energy.up.energy_out_j[-2], rel=1e-9)
        assert down.in_j == pytest.approx(energy.down.energy_in_j[-2], rel=1e-9)
        assert down.out_j == pytest.approx(energy.down.energy_out_j[-1], rel=1e-9)
        assert hand.in_j == pytest.approx(energy.joint.energy_in_j[-1], rel=1e-6)
        assert all(part.margin_j >= 0.0 for part in (up, down, hand))


LOSSY = ("channel=strict", "link.loss=0.1", "link.jitter=uniform", "link.jitter_s=0.012")


@pytest.mark.parametrize("altered", [(), ("master.position.gain=2.0",)])
def test_page_of_the_strict_channel_has_the_reports_balances_of_a_lossy_session(altered):
    """At every block, to the last bit; the report knows a block's v_m and work a step later."""
    scenario = load("carry_16ms", settings_texts=(*LOSSY, *altered), duration_s=2.0)
    traces, name = simulated(scenario), "user1"
    feed = Feed(Layout(USERS, 1), USERS, period_ns=8 * MS)
    simulation, shown = Simulation(scenario, feed, epoch=1), []
    for tick in range(48, 1984, 8):
        simulation.run(tick)
        accounts = feed.user(name).accounts
        every = (accounts.up, accounts.down, accounts.hand)
        shown.append((accounts.known_ns // MS, *((each.in_j, each.out_j) for each in every)))
    steps = (np.array([each[0] for each in shown]) - 7) // 8
    energy = next(each for each in user_energies(traces, scenario) if each.name == name)
    reported = (energy.up, energy.down, energy.joint)
    for way, balance, (late_in, late_out) in zip(
        (1, 2, 3), reported, ((0, 0), (0, 1), (1, 0)), strict=True
    ):
        sums = np.array([each[way] for each in shown])
        if balance is None:  # position feedback alters the wave at the device
            assert altered and way == 2 and np.isnan(sums[:, 1]).all()
            continue
        np.testing.assert_array_equal(sums[:, 0], balance.energy_in_j[steps + late_in])
        np.testing.assert_array_equal(sums[:, 1], balance.energy_out_j[steps + late_out])
    at_port = traces.users[0].energy["u_m"][steps[-1]]
    assert at_port != pytest.approx(shown[-1][1][0], rel=1e-3)  # not what packets were paid with


def test_balance_of_counters_read_at_two_instants_would_be_below_zero(carried):
    _, traces, _ = carried
    user, server = traces.users[0], traces.server
    naive = user.energy["u_m"][:-8] - server.energy_u_s[0][8 : len(user.energy["u_m"])]
    assert naive.min() < -1e-4


def test_channel_without_waves_that_shakes_is_not_passive_and_said_to_be():
    scenario = load("direct_16ms")
    names = [user.name for user in scenario.users]
    _, feed, _ = run_live(scenario, 8000)
    found = verdict(feed, names, storage_j={}, exact_hands=names, notices=[])
    assert found["level"] == "bad" and found["verdict"].startswith("Not passive: user1, hand to")
    assert feed.user("user1").accounts.hand.least_j < -1e-3


def test_verdict_is_good_only_with_every_user_coupled_and_judged(carried):
    _, _, (_, feed, _) = carried
    options = {"storage_j": {}, "exact_hands": USERS, "notices": []}
    assert verdict(feed, USERS, **options)["level"] == "good"
    _, empty = feed_of()
    assert verdict(empty, USERS, **options)["level"] == "caution"


@pytest.mark.parametrize(
    ("texts", "why"),
    [
        ([], "it joined with the device inside the object, and slides to it once there is room"),
        (["controller=direct"], "this controller keeps the distance"),
        (["server.coupling=unknown"], "an environment known by its forces only has no face"),
    ],
)
def test_avatar_that_joined_elsewhere_is_noted_until_it_is_with_its_device(texts, why):
    layout = Layout(("user1",), 1)
    scenario = load("wall", settings_texts=texts)
    feed, notes = Feed(layout, ("user1",), period_ns=16 * MS, scenario=scenario), []
    for start, place_m in ((0, 0.012), (16, 0.010), (32, 0.001), (48, 0.02)):
        feed.on_master("user1", block(start, [0.0] * 16, signals=np.zeros((len(SIGNALS), 16, 1))))
        feed.on_server(step(start, users=1)._replace(avatars=np.full((3, 1, 1), place_m)))
        feed.others = {"user1.lag": 0.04, "user1.impedance": 25.0}
        rows = feed.rows((start + 16) * MS)
        options = {"storage_j": {}, "exact_hands": (), "notices": []}
        notes.append(verdict(feed, ("user1",), **options)["users"]["user1"]["note"])
        if rows:
            apart = "since joining" in notes[-1]
            assert np.isnan(values(layout, rows, "user1.lag")[-1]) == apart  # no F tau/(2b) then
    told = [note for note in notes if "mm from the device since joining" in note]
    assert told
    assert all(why in note for note in told)
    assert "12.0 mm" in told[0] or "10.0 mm" in told[0]
    assert "since joining" not in notes[-1]  # 20 mm of a moving hand later are no such distance


def test_hand_whose_true_motion_is_not_known_is_named_as_not_judged(carried):
    _, _, (_, feed, _) = carried
    found = verdict(feed, USERS, storage_j={}, exact_hands=["user1"], notices=[])
    assert found["level"] == "unknown"
    assert "Energy at the hand is not judged here for user2" in found["verdict"]
