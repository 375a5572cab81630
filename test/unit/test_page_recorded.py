# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A recorded session on its page: rows, packets and texts, and the file that plays them."""

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

from pmwvc_core.traces import HandTargets
from pmwvc_view import recorded
from pmwvc_view.recorded import RecordedSession

PERIOD_S = 0.016
SCENARIO = replace(load("carry_16ms"), duration_s=6.0)


class Recorded:
    """A recorded session, looked at by times."""

    def __init__(self, traces=None, summary=None, scenario=SCENARIO):
        given = traces or simulated(SCENARIO), scenario, summary or judged(SCENARIO)
        self.session = RecordedSession(*given, snapshot_s=PERIOD_S)

    def row(self, time_s):
        """Return the row at a time."""
        return self.session.rows[int(time_s / PERIOD_S + 1e-9)]

    def text(self, time_s):
        """Return the text that holds at a time."""
        index = int(time_s / PERIOD_S + 1e-9)
        return [text for begin, text in self.session.texts() if begin <= index][-1]


def test_rows_are_all_of_the_session_and_packets_in_the_order_of_their_sending():
    session = Recorded().session
    times = session.rows[:, 1]
    np.testing.assert_allclose(times, PERIOD_S * np.arange(len(times)), atol=1e-9)
    assert times[-1] == pytest.approx(6.0, abs=PERIOD_S)
    fates = simulated(SCENARIO).fates
    assert len(session.packets) == sum(len(each.number) for each in fates.values())
    assert (np.diff(session.packets[:, 2]) >= 0.0).all()


def test_user_that_keeps_its_distance_after_rejoining_has_no_lag():
    traces = copy.deepcopy(simulated(SCENARIO))
    server, packets = traces.server, traces.packets["/server/user1/wave_up"]
    packets.epoch[packets.time_s > 3.0] += 5
    server.x_s[0][server.time_s > 3.0] += 0.05
    recorded = Recorded(traces)
    for time_s in (0.0, 2.9, 3.1, 6.0):
        lag = recorded.row(time_s)[recorded.session.layout.slices["user1.lag"]]
        assert np.isnan(lag).all() == (time_s > 3.0)  # no F tau/(2b) is offered then
        assert recorded.text(time_s)["users"]["user2"]["felt"].startswith("buzz ")


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
    user.reason = user.reason[: blocks.sum()]
    user.energy = {name: sums[blocks] for name, sums in user.energy.items()}
    recorded = Recorded(traces)
    for time_s, shown in ((2.9, True), (3.4, True), (3.6, False), (6.0, False)):
        place = recorded.row(time_s)[recorded.session.layout.slices["user1.x_m"]]
        assert np.isfinite(place).all() == shown
        state = recorded.text(time_s)["users"]["user1"]["state"]
        assert (state == "coupled") == shown


def test_verdict_is_that_of_the_report():
    summary = judged(SCENARIO)
    text = Recorded(summary=summary).text(0.0)
    assert text["level"] == "good"
    assert text["verdict"].endswith(summary["verdict"][0]["text"])
    for ok, level in ((False, "bad"), (None, "unknown")):
        summary["verdict"][2] |= {"ok": ok, "text": "user2: something"}
        text = Recorded(summary=summary).text(0.0)
        assert text["level"] == level and text["verdict"].endswith("user2: something")
        others = [
            line["text"] for line in summary["verdict"] if line["text"] != "user2: something"
        ]
        assert text["notices"] == others  # the verdict stands above them already


def test_recorded_targets_are_shown_while_they_held():
    targets = HandTargets(np.array([1.0, 2.0]), np.array([[0.01, 0, 0], [np.nan] * 3]))
    recorded = Recorded(replace(simulated(SCENARIO), targets={"user1": targets}))
    at = recorded.session.layout.slices
    for seconds, held, place in ((0.5, np.nan, np.nan), (1.5, 1.0, 0.01), (2.5, 0.0, np.nan)):
        row = recorded.row(seconds)
        np.testing.assert_equal(row[at["user1.held"]], [held])
        np.testing.assert_equal(row[at["user1.target"]], [place])


def test_lag_is_told_until_it_changes_and_only_that_users():
    changed = replace(SCENARIO, changes="3 user1.link.delay_s=0.03; 4 link.loss=0.1")
    at, rows = {}, {}
    for name, scenario in (("still", SCENARIO), ("changed", changed)):
        session = Recorded(scenario=scenario).session
        at, rows[name] = session.layout.slices, session.rows
    still, later = rows["still"][:, at["user1.lag"]], rows["changed"][:, at["user1.lag"]]
    begun = rows["still"][:, 1] < 3.0
    assert np.isfinite(still).all() and (later[begun] == still[begun]).all()
    assert np.isnan(later[~begun]).all()
    assert np.isfinite(rows["changed"][:, at["user2.lag"]]).all()


@pytest.mark.parametrize("rows", [4000, 50])
def test_page_in_a_file_holds_the_session_and_loads_nothing(monkeypatch, rows):
    monkeypatch.setattr(recorded, "ROWS", rows)
    monkeypatch.setattr(recorded, "PACKETS", 20 * rows)
    lossy = replace(SCENARIO, users=tuple(_lossy(user) for user in SCENARIO.users))
    text = recorded.replay_page(simulated(lossy), lossy, judged(lossy))
    assert not re.search(r"(src|href)=.(?!data:)|https?://(?!www.w3.org)", text)
    found = json.loads(re.search(r'id="recording">(.*?)</script>', text)[1])
    assert found["declared"]["can"] == ["pause", "seek", "speed"]
    layout = found["declared"]["layout"]
    width = sum(count for _, count, _ in layout["columns"])
    played = np.frombuffer(base64.b64decode(found["rows"]), "<f4").reshape(-1, width)
    assert len(played) <= rows + 1
    assert played[-1, 1] == pytest.approx(6.0, abs=2.0 * found["declared"]["snapshot_s"])
    packets = np.frombuffer(base64.b64decode(found["packets"]), "<f4").reshape(-1, 5)
    every = Recorded(simulated(lossy), judged(lossy), lossy).session.packets
    assert np.isnan(packets[:, 3]).sum() == np.isnan(every[:, 3]).sum() > 50  # the lost ones
    assert (len(packets) == len(every)) == (rows == 4000)


def _lossy(user):
    return replace(user, link_up=replace(user.link_up, loss=0.05))


def test_session_of_other_users_has_no_page_in_a_file():
    nobody = replace(simulated(SCENARIO), users=[])
    assert recorded.replay_page(nobody, SCENARIO, judged(SCENARIO)) is None
