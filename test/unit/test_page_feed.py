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
from pmwvc_core.traces import ENERGIES, OF_AVATARS, ServerTraces, UserTraces
from pmwvc_view.feed import rows as rows_module
from pmwvc_view.feed.feed import PATIENCE_S, Feed
from pmwvc_view.feed.rows import touching
from pmwvc_view.feed.tape import joined, since
from pmwvc_view.feed.verdict import Judge, verdict
from pmwvc_view.protocol.snapshot import Layout
from pmwvc_view.recorded import RecordedSession
from pmwvc_view.simulated import Simulation

USERS = ("user1", "user2")
MS = 1_000_000
PERIOD_S = 0.016
LIVE, ALONE = load("live"), load("wall")


def block(start_ms, forces, *, name="user1", late_s=1e-5, first_tick=None, up_j=0.0):
    """Return a block of a master whose position is its time; ``up_j`` is what it has sent."""
    count, first = len(forces), start_ms if first_tick is None else first_tick
    times_s = 1e-3 * (start_ms + np.arange(float(count)))
    zeros = np.zeros((count, 1))
    signals = dict.fromkeys(("xd_m", "f_h", "f_m", "u_m", "u_m_lp"), zeros)
    signals |= {"x_m": 1e3 * times_s[:, np.newaxis], "v_m": zeros + 1e-3}
    sums = dict.fromkeys(ENERGIES, np.zeros(1)) | {"u_m": np.array([up_j])}
    return UserTraces(
        name=name, tick_s=1e-3, time_s=times_s, tick=first + np.arange(count),
        f_applied=np.reshape(np.asarray(forces, dtype=float), (-1, 1)), compute_s=np.zeros(count),
        lateness_s=np.full(count, late_s), block_time_s=np.array([1e-3 * (start_ms + count)]),
        state=np.ones(1, dtype=np.int64), reason=[""], energy=sums | {"device": sums["u_m"]},
        **signals,
    )  # fmt: skip


def step(at_ms, users=USERS, *, number=None, came_j=0.0, avatar_m=None):
    """Return a step of the server at which all is its time [ms]; ``came_j`` is what it got."""
    one, each = np.full((1, 1), float(at_ms)), [np.full(1, 0.0)] * len(users)
    place = one if avatar_m is None else np.full((1, 1), avatar_m)
    own = {name: [place] * len(users) for name in OF_AVATARS}
    return ServerTraces(
        users=list(users), time_s=np.array([1e-3 * at_ms]), periods_s=np.array([8e-3]),
        step=np.array([1 + at_ms // 8 if number is None else number]), x_o=one, xd_o=one,
        target=one, contact=[np.ones(1, dtype=bool)] * len(users),
        state=[np.full(1, 2)] * len(users), energy_u_s=[np.full(1, came_j)] * len(users),
        energy_v_s=each, kinetic=np.zeros(1), potential=np.zeros(1), dissipated=np.zeros(1), **own,
    )  # fmt: skip


def feed_of(users=USERS, scenario=LIVE):
    layout = Layout(users, 1)
    feed = Feed(layout, scenario, period_ns=16 * MS)
    feed.tape.zero(0)
    return layout, feed


def told(feed, *, exact_hands=USERS, scenario=LIVE):
    """Return the text message of now."""
    return verdict(feed, Judge(feed.tape, {}), scenario, exact_hands=exact_hands, notices=[])


def values(layout, snapshots, name):
    return [float(each.row[layout.slices[name]][0]) for each in snapshots]


@settings(max_examples=30)
@given(st.permutations(range(3)), st.integers(1, 5))
def test_rows_do_not_depend_on_whose_trace_comes_first(order, together):
    def run(turns):
        _, feed = feed_of()
        queues = [
            [
                lambda s=s, u=u: feed.on_master(block(s, np.arange(s, s + 8.0), name=u))
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
        feed.on_master(block(start, np.ones(8)))
        feed.on_server(step(start))
    assert feed.rows(100 * MS)[:1] != [] and len(feed.rows(100 * MS)) == 0
    late = feed.rows(48 * MS + round(PATIENCE_S * 1e9) + 60 * MS)
    assert late and np.isnan(values(layout, late, "user2.x_m")).all()
    assert values(layout, late, "user1.x_m")[-1] > 0.0


def test_ticks_that_came_after_their_row_are_in_the_extremes_of_the_next_one():
    """A loop that stalled sends its trace late: its lateness must be seen."""
    layout, feed = feed_of()
    feed.on_master(block(0, np.ones(8), name="user2"))
    for start in range(0, 200, 8):
        feed.on_master(block(start, np.ones(8)))
        feed.on_server(step(start))
    early = feed.rows(200 * MS)
    assert len(early) > 2 and np.nanmax(values(layout, early, "user2.f_max")) == 1.0
    feed.on_master(block(8, [1.0, 5.0] * 4, late_s=0.09, name="user2"))
    feed.on_master(block(16, np.ones(184), name="user2"))
    late = feed.rows(260 * MS)
    assert values(layout, late, "user2.f_max")[0] == 5.0
    assert values(layout, late, "user2.lateness")[0] == 0.09


def test_user_whose_traces_stop_is_no_longer_shown_as_coupled():
    layout, feed = feed_of()
    rows = []
    feed.on_master(block(0, np.ones(8), name="user2"))  # no row shows it yet
    assert "any more" not in told(feed)["verdict"]
    for start in range(0, 1200, 8):
        for user in USERS[: 1 if start >= 400 else 2]:
            feed.on_master(block(start, np.ones(8), name=user))
        feed.on_server(step(start))
        rows += feed.rows((start + 8) * MS)
    places = np.array(values(layout, rows, "user2.x_m"))
    times = np.array(values(layout, rows, "time_s"))
    assert np.isfinite(places[times < 0.9]).all() and np.isnan(places[times > 0.92]).all()
    found = told(feed)
    assert found["verdict"] == "Not all users are coupled: user2 sends nothing any more."
    assert found["users"]["user2"]["state"] == "no data"
    for user in USERS:
        feed.on_master(block(1200, np.ones(16), name=user))
    feed.on_server(step(1216))
    feed.rows(1300 * MS)
    assert feed.users["user2"].state == 1


@pytest.mark.parametrize("again", [None, "master", "server", "user"])
def test_energy_of_counters_that_began_anew_is_no_longer_judged(again):
    """A node was started again, or its user came back to the server."""
    _, feed = feed_of(("user1",), ALONE)
    for start in range(0, 400, 8):
        since = 200 * (start >= 200)
        sent = 1e-3 * (start - since * (again == "master"))
        came = 1e-3 * max(start - 8 - since * (again in ("server", "user")), 0)
        first = start - since * (again == "master")
        number = 1 + (start - since * (again == "server")) // 8
        feed.on_master(block(start, np.ones(8), first_tick=first, up_j=sent))
        feed.on_server(step(start + 4, ("user1",), number=number, came_j=0.5 * came))
        feed.rows((start + 8) * MS)
    user = feed.users["user1"]
    assert user.known == user.judged == (again is None)
    assert feed.worst["user1", "up"].passive is not False
    assert feed.server_judged == (again in (None, "master"))


@pytest.mark.parametrize(("late_j", "judged"), [(0.0, True), (0.1, False)])
def test_counters_that_began_at_different_times_are_not_judged(late_j, judged):
    _, feed = feed_of(("user1",), ALONE)
    for start in range(0, 400, 8):
        feed.on_master(block(start, np.ones(8), up_j=1e-3 * start))
        feed.on_server(step(start + 4, ("user1",), came_j=0.5e-3 * max(start - 8, 0) + late_j))
        feed.rows((start + 8) * MS)
    assert feed.users["user1"].judged is judged
    assert all(found.passive is not False for found in feed.worst.values())


def run_live(scenario, ticks, poll=16):
    """Return feed and rows of a scenario that is simulated as for a page."""
    layout = Layout([user.name for user in scenario.users], scenario.dof)
    feed, rows = Feed(layout, scenario, period_ns=poll * MS), []
    simulation = Simulation(scenario)
    feed.tape.zero(0)
    for tick in range(poll, ticks + 1, poll):
        simulation.step_to(tick, feed)
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
        assert np.isfinite(row[layout.slices[f"{user.name}.energy_hand_in"]]).all()
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
def test_page_has_the_reports_balances(texts):
    """Also those of later seconds: sums count from the start of the nodes."""
    scenario = load("carry_16ms", settings_texts=texts, duration_s=2.4)
    layout, feed, rows = run_live(scenario, 2400)
    for energy in user_energies(simulated(scenario), scenario):
        shown = feed.users[energy.name]
        assert energy.parts.keys() == shown.energy.parts.keys()
        for part, balance in shown.energy.parts.items():
            reported = energy.parts[part]
            at = np.rint(1e3 * balance.time_s).astype(int) // 8
            assert 50 < len(at) < 160 and at[-1] > 280  # a second, of 2.4
            for name in ("energy_in_j", "energy_out_j"):
                own, whole = getattr(balance, name), getattr(reported, name)
                np.testing.assert_allclose(own[:-2], whole[at][:-2], rtol=1e-12, atol=1e-15)
            assert shown.least_j[part] == pytest.approx(reported.minimum_j, abs=1e-12)
            column = f"{energy.name}.energy_{rows_module.WAYS[part]}_in"
            assert values(layout, rows, column)[-1] == balance.energy_in_j[-1]
    assert all(found.passive is not False for found in feed.worst.values())


def test_balance_of_counters_read_at_two_instants_would_be_below_zero(carried):
    _, traces, _ = carried
    user, server = traces.users[0], traces.server
    naive = user.energy["u_m"][:-8] - server.energy_u_s[0][8 : len(user.energy["u_m"])]
    assert naive.min() < -1e-4


def test_channel_without_waves_that_shakes_is_not_passive_and_said_to_be():
    scenario = load("direct_16ms")
    _, feed, _ = run_live(scenario, 8000)
    found = told(feed, scenario=scenario)
    assert found["level"] == "bad" and found["verdict"].startswith("Not passive: user1, port")
    assert feed.worst["user1", "hand_port"].least_j < -1e-3


def test_verdict_is_good_only_with_every_user_coupled_and_judged(carried):
    scenario, _, (_, feed, _) = carried
    assert told(feed, scenario=scenario)["level"] == "good"
    unknown = told(
        feed, exact_hands=["user1"], scenario=scenario
    )  # the true motion of the other is not known
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
        traces = block(start, [0.0] * 16)
        feed.on_master(replace(traces, x_m=np.zeros((16, 1))))
        feed.on_server(step(start, ("user1",), avatar_m=place_m))
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


@pytest.mark.parametrize("start_s", [-1.0, 0.004, 0.02, 1.0])
def test_contacts_stay_with_their_step(start_s):
    """By the time that each contact holds as its place, in parts of 2, 0 and 1 contacts a step."""
    parts = []
    for at_ms, rows in ((0, [0, 0, 1]), (16, []), (32, [0, 1, 1])):
        traces = [step(at_ms + 8 * n, ("user1",)) for n in (0, 1)]
        places = [1e-3 * (at_ms + 8 * row) for row in rows]
        contacts = np.array(
            [[row, 0, -1, place, *[0] * 5] for row, place in zip(rows, places, strict=True)]
        )
        parts.append(replace(joined(traces), contacts=contacts.reshape(-1, 9)))
    found = since(joined(parts), start_s)
    times_s = found.time_s[found.contacts[:, 0].astype(int)]
    assert times_s.tolist() == found.contacts[:, 3].tolist()
    every = [0.0, 0.0, 0.008, 0.032, 0.04, 0.04]
    assert found.contacts[:, 3] == pytest.approx([each for each in every if each > start_s])


def test_row_has_the_eight_strongest_contacts_with_the_force_on_the_earlier_body():
    traces = joined([step(8 * n, ("user1",)) for n in range(3)])
    pairs = [(-1, 0), (0, -1), (1, 0), (0, 1), (2, 1)] + [(-1, 0)] * 4  # of step 1, none of others
    rows = [[1.0, *pair, 0.1 * n, 0, 0, 0, 0, 10.0 - n] for n, pair in enumerate(pairs)]
    shown = touching(replace(traces, contacts=np.array(rows))).reshape(3, 8, 6)
    assert np.isnan(shown[[0, 2]]).all()
    np.testing.assert_allclose(shown[1, :, 0], 0.1 * np.arange(8))
    signs = [1, -1, 1, -1, 1, 1, 1, 1]  # given: on the second
    np.testing.assert_allclose(shown[1, :, 5], signs * (10.0 - np.arange(8)))
    assert np.isnan(touching(traces)).all()
