# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Verdicts and numbers of a summary."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support import handmade
from support.handmade import DRIFT_M, FORCE_N, session

from pmwvc_analysis.prediction.lag import lag_s
from pmwvc_analysis.verdicts.outcomes import offsets
from pmwvc_analysis.verdicts.verdicts import summary

PAGE = Path(__file__).resolve().parents[2] / "docs" / "file_format.md"


def judged(traces, **overrides):
    return summary(traces, handmade.scenario(**overrides))


def documented(head):
    """Return the rows of a table of the page, by their keys."""
    _, _, table = PAGE.read_text("utf-8").partition(f"| {head} | meaning |\n|---|---|\n")
    rows = (line.split(" | ", 1) for line in table.partition("\n\n")[0].splitlines())
    return {key: text for keys, text in rows for key in re.findall(r"`(\w+)", keys)}


def test_the_keys_are_those_that_are_documented():
    result, rows = judged(session()), documented("key")
    assert set(result) == set(rows)
    deeper = {"p50", "p99", "max", "owner", "start_s", "end_s"}
    for name in ("object", "links", "prediction", "recording"):
        found = result[name][0] if name == "links" else result[name]
        assert set(found) == set(re.findall(r"`(\w+)", rows[name])) - deeper
    for user in result["users"]:
        assert set(user) == {"name", *documented("key of a user")}
    percentiles = [user["lateness_us"], user["compute_us"], result["links"][0]["delay_s"]]
    assert [set(each) for each in percentiles] == [{"p50", "p99", "max"}] * 3


def test_the_press_has_its_known_numbers():
    result = judged(session())
    assert result["stable"] is True
    assert result["instability"] is None
    for user, sign in zip(result["users"], (1.0, -1.0), strict=True):
        assert user["passive"] is True
        assert user["force_final_n"] == pytest.approx(sign * FORCE_N)
        assert user["avatar_force_final_n"] == pytest.approx(sign * FORCE_N)
        assert user["force_peak_n"] == pytest.approx(FORCE_N)
        assert user["drift_m"] == pytest.approx(sign * DRIFT_M)
        assert user["ticks"] == 4000
        assert user["ticks_missing"] == 0
        assert user["tick_rate_hz"] == pytest.approx(1000.0)
    assert result["links"][0]["delay_s"]["p50"] == pytest.approx(0.016)
    assert result["links"][0]["lost"] == 0


def test_a_summary_is_json_without_nan_whatever_is_missing():
    traces = session()
    traces.server = None
    traces.fates = {}
    traces.users[0].f_h[:] = np.nan
    result = summary(traces, None)
    text = json.dumps(result, allow_nan=False)
    assert json.loads(text)["users"][0]["passive"] is None
    assert result["object"]["position_final_m"] is None


def test_packets_are_counted_by_their_fates():
    traces = session()
    fates = traces.fates["user1/up"]
    fates.fate[10:20], fates.time_out_ns[10:20] = 1, 0
    fates.fate[30] = 3
    fates.time_out_ns[30] = 0
    fates.time_out_ns[50] += 20_000_000  # overtaken by the two behind it
    fates.fate[60] = 2  # a copy of the one before
    fates.seq[60] = fates.seq[59]
    link = next(x for x in judged(traces)["links"] if x["name"] == "user1/up")
    assert (link["sent"], link["lost"], link["dropped"]) == (499, 10, 1)
    assert (link["received"], link["duplicated"]) == (487, 1)
    assert link["reordered"] == 1
    assert link["delay_s"]["max"] == pytest.approx(0.036)


def test_an_avatar_that_starts_elsewhere_is_compared_from_there():
    traces = session()
    traces.server.x_s[0] -= 0.03
    user = judged(traces)["users"][0]
    assert user["drift_m"] == pytest.approx(DRIFT_M)
    assert user["coherency_rms_m"] < 1e-3


@pytest.mark.parametrize("absent", [True, False])
def test_a_user_that_comes_back_has_a_new_avatar(absent):
    traces = session()
    packets = traces.packets["/server/user1/wave_up"]
    packets.epoch[packets.time_s > 3.0] += 5
    traces.server.x_s[0][traces.server.time_s > 3.0] += 0.05
    if absent:
        traces.server.state[0][(traces.server.time_s > 2.5) & (traces.server.time_s < 3.004)] = 0
    user = judged(traces)["users"][0]
    assert user["coherency_rms_m"] < 1e-3
    assert user["drift_m"] == pytest.approx(DRIFT_M)
    assert user["kept_apart_m"] == pytest.approx(-0.05)
    assert user["kept_apart"].startswith("avatar 50.0 mm from the device since joining: it joined")


def test_what_is_before_the_first_packet_does_not_count():
    traces = session()
    traces.server.state[0][:3] = 3
    traces.server.x_s[0][:3] = 0.5
    assert judged(traces)["users"][0]["coherency_rms_m"] < 1e-3


def test_a_server_that_goes_on_without_the_users_does_not_count():
    traces = session()
    gone = traces.server.time_s > 3.8
    for user in traces.users:
        kept = user.time_s <= 3.8
        for name in ("time_s", "tick", "lateness_s", "compute_s"):
            setattr(user, name, getattr(user, name)[kept])
        for name in ("x_m", "xd_m", "f_h", "f_m", "f_applied", "u_m", "u_m_lp", "v_m"):
            setattr(user, name, getattr(user, name)[kept])
    for place in range(2):
        traces.server.f_s[place][gone] = 0.0
        traces.server.state[place][gone] = 0
    traces.server.x_o[gone] = 0.1
    result = judged(traces)
    assert result["users"][0]["avatar_force_final_n"] == pytest.approx(FORCE_N)
    assert result["users"][0]["drift_m"] == pytest.approx(DRIFT_M)
    assert result["object"]["position_final_m"] == pytest.approx(0.0)


def restless(traces):
    user = traces.users[0]
    user.xd_m = user.xd_m + 0.1 * np.sin(2 * np.pi * 30.0 * user.time_s)[:, np.newaxis]


def cut_by_a_limit(traces):
    traces.users[0].f_applied *= 0.8


def on_the_move(traces):
    way_m = 0.01 * traces.server.time_s[:, np.newaxis]
    for place in (traces.server.x_s[0], traces.packets["/server/user1/wave_down"].position):
        place += way_m


def at_rest(traces):
    pass


@pytest.mark.parametrize(
    ("altered", "network", "hit", "words"),
    [
        (at_rest, {}, True, "(hit;"),
        (restless, {}, None, "the session was not stable"),
        (cut_by_a_limit, {}, None, "the device was held with 0.80 N, its avatar with 1.00 N"),
        (on_the_move, {}, None, "it still changed by 4."),
        (at_rest, {"link__loss": 0.1}, None, "is not known before"),
        (at_rest, {"master__rate_drop": 4}, None, "skipped, is not known before"),
    ],
)
def test_an_offset_is_compared_where_it_is_that_of_a_press_at_rest(altered, network, hit, words):
    traces = session()
    altered(traces)
    found = [each for each in judged(traces, **network)["outcomes"] if each["owner"] == "user1"]
    assert [(each["what"], each["hit"]) for each in found] == [("offset", hit)]
    assert words in found[0]["text"]


def test_a_prediction_without_limits_is_open_where_limits_take_over():
    traces = session(gain=1.1)
    traces.users[0].state[400:] = 3
    traces.users[0].reason[400:] = ["faster than 1.5 m/s"] * 100
    found = judged(traces, device__damping=1.0)
    assert found["instability"] == "limited by safety" and found["prediction"]["stable"]
    assert [each["hit"] for each in found["outcomes"] if each["what"] == "stability"] == [None]


def said_of(scenario, force, drift_m, source="simulated", **measured):
    """What is said of the offset of a press at rest."""
    entry = {"name": "user1", "force_final_n": force, "avatar_force_final_n": force}
    entry |= {"drift_m": drift_m, "drift_change_m": 0.0}
    entry |= {"force_commanded_final_n": force, "velocity_final_m_s": 0.0, **measured}
    summary = {"source": source, "stable": True, "users": [entry], "events": []}
    (found,) = offsets(scenario, summary)
    return found


@given(
    sign=st.sampled_from([1.0, -1.0]),
    force=st.floats(0.3, 5.0),
    delay_s=st.floats(0.0, 0.05),
    coupling=st.sampled_from(["implicit", "one_step_delay"]),
)
def test_an_offset_is_that_of_the_lag_within_its_tolerance(sign, force, delay_s, coupling):
    """Also where the avatar leads by more than the waves lag: below zero in that direction."""
    scenario = handmade.scenario(server__coupling=coupling, link__delay_s=delay_s, link__loss=0.0)
    (user, _) = scenario.users
    per_lag = sign * force / (2.0 * handmade.IMPEDANCE)
    even_m = per_lag * lag_s(user, scenario, live=False)
    found = said_of(scenario, sign * force, even_m)
    assert found.hit is True, found.text
    for off_m in (-1.01 * found.tolerance, 1.01 * found.tolerance):
        assert said_of(scenario, sign * force, even_m + off_m).hit is False  # the control


@pytest.mark.parametrize("channel", ["strict", "plain"])
@pytest.mark.parametrize(
    ("measured", "words"),
    [
        ({"force_commanded_final_n": 1.05}, "held with 1.00 N by a limit, 1.05 N were commanded"),
        ({"velocity_final_m_s": -0.1}, "the device still moved with 100 mm/s"),
        ({"velocity_final_m_s": -0.01}, None),  # the control: at rest, it is a miss
    ],
)
def test_a_press_that_moves_or_is_limited_at_the_end_is_no_press_at_rest(channel, measured, words):
    """With 80 ms up and 5 ms down it was "missed" by 0.9 mm, as the cube still moved."""
    found = said_of(handmade.scenario(channel=channel, link__loss=0.0), 1.0, 5e-3, **measured)
    assert found.hit is (None if words else False)
    assert (words or "missed") in found.text


@pytest.mark.parametrize("channel", ["strict", "plain"])
def test_how_late_the_packets_of_a_live_session_come_was_not_known_before(channel):
    scenario = handmade.scenario(channel=channel, link__loss=0.0)
    found = said_of(scenario, 1.0, 1e-3, "live")
    assert found.hit is None and "measured +1.00 mm" in found.text
    assert "how late packets come" in found.text
