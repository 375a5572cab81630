# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The feed of a page: traces of several nodes, as they come, on one grid."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.plain import load

from pmwvc_core.traces import ENERGIES, OF_AVATARS, ServerTraces, UserTraces
from pmwvc_view.feed.feed import PATIENCE_S, Feed
from pmwvc_view.feed.rows import touching
from pmwvc_view.feed.tape import joined, since
from pmwvc_view.feed.verdict import Judge, verdict
from pmwvc_view.protocol.snapshot import Layout

USERS = ("user1", "user2")
MS = 1_000_000
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
        energy_v_s=each, kinetic=np.zeros(1), potential=np.zeros(1), dissipated=np.zeros(1),
        looked_ns=np.zeros(1, dtype=np.int64), **own,
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


@settings(max_examples=15)
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


@pytest.mark.parametrize(
    ("again", "late_j"),
    [(None, 0.0), ("master", 0.0), ("server", 0.0), ("user", 0.0), (None, 0.1)],
)
def test_energy_of_counters_that_began_anew_or_at_different_times_is_not_judged(again, late_j):
    """A node was started again, or its user came back to the server."""
    _, feed = feed_of(("user1",), ALONE)
    for start in range(0, 400, 8):
        since = 200 * (start >= 200)
        sent = 1e-3 * (start - since * (again == "master"))
        came = 1e-3 * max(start - 8 - since * (again in ("server", "user")), 0)
        first = start - since * (again == "master")
        number = 1 + (start - since * (again == "server")) // 8
        feed.on_master(block(start, np.ones(8), first_tick=first, up_j=sent))
        feed.on_server(step(start + 4, ("user1",), number=number, came_j=0.5 * came + late_j))
        feed.rows((start + 8) * MS)
    user = feed.users["user1"]
    assert user.known == user.judged == (again is None and not late_j)
    assert all(found.passive is not False for found in feed.worst.values())
    assert feed.server_judged == (again in (None, "master"))


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
