# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A recorded session on the page: played, stopped, moved along its time line."""

import asyncio
import base64
import copy
import dataclasses
import json
import re
from dataclasses import replace

import numpy as np
import pytest
from support.plain import load
from support.simulated import judged, simulated

from pmwvc_analysis.verdicts.verdicts import summary
from pmwvc_core.errors import RecordingError
from pmwvc_core.traces import HandTargets
from pmwvc_view import replay_page
from pmwvc_view.recorded import RecordedSession

PERIOD_S = 0.016
SCENARIO = replace(load("carry_16ms"), duration_s=6.0)


class Player:
    """A recorded session under a clock of the test's own."""

    def __init__(self, traces=None, summary=None, scenario=SCENARIO):
        self.now_s = 0.0
        self.session = RecordedSession(
            traces or simulated(SCENARIO),
            scenario,
            summary or judged(SCENARIO),
            snapshot_s=PERIOD_S,
            clock=lambda: self.now_s,
        )

    def after(self, seconds):
        """Let time pass; return the rows of it."""
        self.now_s += seconds
        return np.array([each.row for each in self.session.poll()])


def test_session_waits_at_its_beginning_and_plays_every_row_once():
    player = Player()
    assert len(player.after(0.0)) == 1 and len(player.after(5.0)) == 0
    assert asyncio.run(player.session.pause(False)).done
    rows = np.concatenate([rows for _ in range(70) if len(rows := player.after(0.1))])
    np.testing.assert_allclose(rows[:, 1], PERIOD_S * np.arange(1, len(rows) + 1), atol=1e-9)
    assert rows[-1, 1] == pytest.approx(6.0, abs=PERIOD_S)
    assert player.session.news()["play"]["paused"]


def test_time_line_is_moved_while_playing_and_while_paused():
    player = Player()
    player.after(0.0)
    for seconds, wanted in ((3.0, 3.0), (1.0, 1.0), (99.0, 6.0), (-1.0, 0.0)):
        assert player.session.seek(seconds).done
        rows = player.after(0.5)
        assert len(rows) == 1 and rows[0, 1] == pytest.approx(wanted, abs=PERIOD_S)
    asyncio.run(player.session.pause(False))
    player.session.speed(0.1)
    assert player.after(1.0)[-1, 1] == pytest.approx(0.1, abs=PERIOD_S)
    assert not player.session.speed(100.0).done


def test_packets_are_played_with_the_rows_in_which_they_were_sent():
    player = Player()
    asyncio.run(player.session.pause(False))
    player.now_s = 2.0
    snapshots = player.session.poll()
    sent = np.concatenate([each.packets for each in snapshots])
    fates = simulated(SCENARIO).fates
    until_ns = snapshots[-1].row[1] * 1e9 + 1.0
    assert len(sent) == sum(int((each.time_in_ns <= until_ns).sum()) for each in fates.values())
    for row, packets in ((each.row, each.packets) for each in snapshots):
        assert (packets[:, 2] <= row[1] + 1e-9).all()


def test_user_that_keeps_its_distance_after_rejoining_is_noted_as_in_the_report():
    traces = copy.deepcopy(simulated(SCENARIO))
    server, packets = traces.server, traces.packets["/server/user1/wave_up"]
    packets.epoch[packets.time_s > 3.0] += 5
    server.x_s[0][server.time_s > 3.0] += 0.05
    player = Player(traces)
    notes = {}
    for time_s in (0.0, 2.9, 3.1, 6.0):
        player.session.seek(time_s)
        row = player.after(0.0)[-1]
        lag = row[player.session.layout.slices["user1.lag"]]
        assert np.isnan(lag).all() == (time_s > 3.0)  # no F tau/(2b) is offered then
        users = player.session.news()["text"]["users"]
        notes[time_s] = users["user1"]["note"]
        assert users["user2"]["note"] == ""
        assert users["user2"]["felt"].startswith("buzz ")
    assert notes[0.0] == notes[2.9] == ""
    assert notes[3.1].startswith("avatar 50.0 mm from the device since joining: it joined with")
    assert notes[6.0] == summary(traces, SCENARIO)["users"][0]["kept_apart"]
    assert any(notes[6.0] in json.dumps(text) for _, text in player.session.whole()[2])


def test_user_of_whom_nothing_was_recorded_for_a_while_is_not_shown_there():
    traces = copy.deepcopy(simulated(SCENARIO))
    user = traces.users[0]
    ticks, blocks = user.time_s < 3.0, user.block_time_s < 3.0
    for field in dataclasses.fields(user):
        value, kept = getattr(user, field.name), None
        for rows in (ticks, blocks):
            if isinstance(value, np.ndarray) and len(value) == len(rows):
                kept = value[rows]
        if kept is not None:
            setattr(user, field.name, kept)
    user.reason, user.energy = user.reason[: blocks.sum()], {}
    player = Player(traces)
    for time_s, shown in ((2.9, True), (3.4, True), (3.6, False), (6.0, False)):
        player.session.seek(time_s)
        row = player.after(0.0)[-1]
        assert np.isfinite(row[player.session.layout.slices["user1.x_m"]]).all() == shown
        state = player.session.news()["text"]["users"]["user1"]["state"]
        assert (state == "coupled") == shown


def test_verdict_is_that_of_the_report():
    summary = judged(SCENARIO)
    text = Player(summary=summary).session.news()["text"]
    assert text["level"] == "good"
    assert text["verdict"].endswith(summary["verdict"][0]["text"])
    for ok, level in ((False, "bad"), (None, "unknown")):
        summary["verdict"][2] |= {"ok": ok, "text": "user2: something"}
        text = Player(summary=summary).session.news()["text"]
        assert text["level"] == level and text["verdict"].endswith("user2: something")
        others = [
            line["text"] for line in summary["verdict"] if line["text"] != "user2: something"
        ]
        assert text["notices"] == others  # the verdict stands above them already


def test_recorded_targets_are_shown_while_they_held():
    targets = HandTargets(np.array([1.0, 2.0]), np.array([[0.01, 0, 0], [np.nan] * 3]))
    player = Player(replace(simulated(SCENARIO), targets={"user1": targets}))
    at = player.session.layout.slices
    for seconds, held, place in ((0.5, np.nan, np.nan), (1.5, 1.0, 0.01), (2.5, 0.0, np.nan)):
        player.session.seek(seconds)
        row = player.after(0.0)[-1]
        np.testing.assert_equal(row[at["user1.held"]], [held])
        np.testing.assert_equal(row[at["user1.target"]], [place])


def test_lag_is_told_until_it_changes_and_only_that_users():
    changed = replace(SCENARIO, changes="3 user1.link.delay_s=0.03; 4 link.loss=0.1")
    at, rows = {}, {}
    for name, scenario in (("still", SCENARIO), ("changed", changed)):
        player = Player(scenario=scenario)
        at, rows[name] = player.session.layout.slices, player.session._rows
    still, later = rows["still"][:, at["user1.lag"]], rows["changed"][:, at["user1.lag"]]
    begun = rows["still"][:, 1] < 3.0
    assert np.isfinite(still).all() and (later[begun] == still[begun]).all()
    assert np.isnan(later[~begun]).all()
    assert np.isfinite(rows["changed"][:, at["user2.lag"]]).all()


def test_recording_of_other_users_is_refused():
    with pytest.raises(RecordingError, match="nothing was recorded of the users"):
        Player(replace(simulated(SCENARIO), users=[]))


@pytest.mark.parametrize("rows", [4000, 50])
def test_page_in_a_file_holds_the_session_and_loads_nothing(monkeypatch, rows):
    monkeypatch.setattr(replay_page, "ROWS", rows)
    monkeypatch.setattr(replay_page, "PACKETS", 20 * rows)
    lossy = replace(SCENARIO, users=tuple(_lossy(user) for user in SCENARIO.users))
    text = replay_page.replay_page(simulated(lossy), lossy, judged(lossy))
    assert not re.search(r"(src|href)=.(?!data:)|https?://(?!www.w3.org)", text)
    found = json.loads(re.search(r'id="recording">(.*?)</script>', text)[1])
    layout = found["declared"]["layout"]
    width = sum(count for _, count, _ in layout["columns"])
    played = np.frombuffer(base64.b64decode(found["rows"]), "<f4").reshape(-1, width)
    assert len(played) <= rows + 1
    assert played[-1, 1] == pytest.approx(6.0, abs=2.0 * found["declared"]["snapshot_s"])
    packets = np.frombuffer(base64.b64decode(found["packets"]), "<f4").reshape(-1, 5)
    every = Player(simulated(lossy), judged(lossy), lossy).session._packets
    assert np.isnan(packets[:, 3]).sum() == np.isnan(every[:, 3]).sum() > 50  # the lost ones
    assert (len(packets) == len(every)) == (rows == 4000)


def _lossy(user):
    return replace(user, link_up=replace(user.link_up, loss=0.05))


def test_session_of_other_users_has_no_page_in_a_file():
    nobody = replace(simulated(SCENARIO), users=[])
    assert replay_page.replay_page(nobody, SCENARIO, judged(SCENARIO)) is None
