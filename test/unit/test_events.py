# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The list of events: safety, membership and contact of simulated and recorded sessions; a box
that slips in a grip or falls out of it, against what the scene knows of itself (a pad slips where
its force along the face is mu F).
"""

import numpy as np
import pytest
from support import handmade
from support import plain as scenarios

from pmwvc_analysis.events.events import complete
from pmwvc_analysis.verdicts.verdicts import summary
from pmwvc_bringup.scenarios import find, read
from pmwvc_core.master.safety import UNCOUPLED
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.scenes import body
from pmwvc_core.simulation.session import simulate_one


def listed(traces, kind, scenario=None):
    events = complete(traces, scenario or handmade.scenario())
    return [event for event in events if event["kind"] == kind]


def test_joining_is_an_event_and_the_end_of_the_session_none():
    traces = handmade.session()
    assert [event["who"] for event in listed(traces, "join")] == ["user1", "user2"]
    traces.server.state[0][-3:] = 0
    assert listed(traces, "leave") == []


def test_a_hand_that_left_its_avatar_by_the_clutch_is_no_limit_of_safety():
    traces = handmade.session()
    user = traces.users[0]
    user.state[40:80], user.reason[40:80] = 0, [UNCOUPLED] * 40
    what = [event["what"] for event in listed(traces, "damping")]
    assert what == [UNCOUPLED, "force restored in full"]


def test_leaving_ends_a_contact():
    traces = handmade.session()
    gone = traces.server.time_s > 2.0
    traces.server.state[0][gone] = 0
    traces.server.contact[0][gone] = False
    (leave,) = listed(traces, "leave")
    (release,) = listed(traces, "release")
    assert leave["time_s"] == pytest.approx(release["time_s"], abs=0.02)


def test_a_contact_that_the_motion_parts_reports_it_and_bouncing_is_one():
    traces = handmade.session()
    time_s, contact = traces.server.time_s, traces.server.contact[0]
    contact[(time_s > 1.0) & (time_s < 1.03)] = False  # too short
    contact[(time_s > 2.0) & (time_s < 2.5)] = False
    (release,) = listed(traces, "release")
    assert release["time_s"] == pytest.approx(2.0, abs=0.02)
    assert release["what"] == "contact lost"
    assert len([e for e in listed(traces, "contact") if e["who"] == "user1"]) == 2


def test_contact_that_stays_from_step_to_step_of_a_slow_server_is_not_lost():
    texts = ["server.period_s=0.1", "master.rate_drop=100"]
    slow = scenarios.load("carry_16ms", settings_texts=texts, duration_s=4.0)
    assert listed(simulate_one(slow), "release", slow) == []


def test_an_environment_that_tells_of_no_contact_shows_it_by_its_force():
    traces = handmade.session()
    traces.server.contact[0][:] = False
    made = [e for e in listed(traces, "contact") if e["who"] == "user1"]
    assert len(made) == 1
    assert 0.5 < made[0]["time_s"] < 0.8  # the press begins at 0.5 s


def test_the_safety_limits_letting_go_is_an_event_with_its_cause():
    traces = handmade.session()
    user = traces.users[0]
    for rows, state, reason in (
        (slice(250, 260), 2, "server silent: damping only"),
        (slice(260, 300), 2, "server silent: damping released"),
        (slice(300, 310), 0, "soft start"),
    ):
        user.state[rows] = state
        user.reason[rows] = [reason] * (rows.stop - rows.start)
    (release,) = listed(traces, "release")
    damping, restored = listed(traces, "damping")
    assert damping["what"] == "safety limits: server silent: damping only"
    assert release["what"] == "safety limits: server silent: damping released"
    assert restored["what"] == "force restored in full"
    assert damping["time_s"] < release["time_s"] < restored["time_s"]


def test_a_fault_takes_the_force():
    traces = handmade.session()
    traces.users[0].state[300:] = 3
    traces.users[0].reason[300:] = ["faster than 5 m/s: no force until re-armed"] * 200
    (release,) = listed(traces, "release")
    assert "safety fault: faster than 5 m/s" in release["what"]


def test_a_limited_force_is_one_event_with_both_forces():
    traces = handmade.session()
    user = traces.users[0]
    user.f_applied[2000:2100] = 0.5 * user.f_m[2000:2100]
    (limit,) = listed(traces, "limit")
    assert limit["time_s"] == pytest.approx(2.0)
    assert limit["what"] == "force limited for 0.100 s: up to 1.00 N commanded, 0.50 N applied"
    user.f_applied[2020:2080] = user.f_m[2020:2080]  # limits close to each other are one event
    (limit,) = listed(traces, "limit")
    assert limit["what"].startswith("force limited for 0.040 s of 0.100 s: up to 1.00 N")


def test_a_live_environment_that_a_damper_replaced_is_named_with_time_and_count():
    """In virtual time the reason is known, too, and stands in the metadata instead."""
    traces = handmade.session()
    traces.server.contained = np.repeat([0, 1, 3], [100, 50, len(traces.server.step) - 150])
    assert listed(traces, "environment") == []
    traces.source = "live"
    (found,) = listed(traces, "environment")
    assert found["what"].startswith("environment or coupling failed in 3 steps: ")
    assert found["time_s"] == traces.server.time_s[100]
    traces.server.contained = np.zeros(0, dtype=int)  # recorded before there was a count
    assert listed(traces, "environment") == []


@pytest.mark.parametrize(
    ("way", "words"),
    [("up", "no packets reach the server"), ("down", "the user receives no packets")],
)
def test_of_a_lost_direction_it_is_said_which(way, words):
    """With the downlink out it was "no packets reach the server", where all of them did."""
    texts = [f"user1.link.{way}.schedule=0.4 outage; 0.8 base", "channel=strict"]
    scenario = scenarios.load("carry_16ms", duration_s=1.3, settings_texts=texts)
    found = complete(simulate_one(scenario), scenario)
    said = [e["what"] for e in found if (e["who"], e["kind"]) == ("user1", "damping")]
    assert said == [f"{words}: the avatar is only damped", "the avatar is coupled again"]


MU, WEIGHT_N = 0.6, 0.2 * 9.81
GIVES = 2.6 / 2.06  # of a hand's squeeze, what its arm takes back
HASTE = {"task.grip_s": 0.3, "task.grip_rise_s": 0.5, "task.move_s": 1.5}


def simulated(name, duration_s, without=(), **values):
    given = {
        each: own for each, own in read(find(name)).items() if each.split(".")[0] not in without
    }
    given["users"] -= len(without)
    scenario = parse_scenario(given, source=name, overrides=values, duration_s=duration_s)
    return scenario, simulate_one(scenario)


def told(scenario, traces):
    return [each for each in complete(traces, scenario) if each["kind"] in ("slip", "drop")]


@pytest.fixture
def slipping(monkeypatch):
    """Tell step by step whether pads slip: as the box itself has it."""
    found, newest, (pressed, meet) = [], {}, (body.pressed, body.Box.meet)

    def watched(points, *given):
        after = pressed(points, *given)
        along = after.force + after.pressing[:, None] * points.normal
        most = points.friction * after.pressing
        pads = slice(None, -len(body.CORNERS))
        slips = (np.linalg.norm(along, axis=1) > 0.999 * most) & (most > body.LEAST_N)
        newest["slips"] = slips[pads]
        return after

    def met(box, *given):
        rates = meet(box, *given)
        found.append(newest["slips"].any())
        return rates

    monkeypatch.setattr(body, "pressed", watched)
    monkeypatch.setattr(body.Box, "meet", met)
    return found


def lifted(force_n):
    own = {"server.body.friction": MU, "operator.squeeze": GIVES * force_n, "dof": 3}
    return simulated("lift_body", 4.0, **own, **HASTE)


def test_a_grip_that_carries_the_weight_does_not_slip(slipping):
    force_n = 2.1
    assert 2.0 * MU * force_n > WEIGHT_N
    assert not told(*lifted(force_n))
    assert not any(slipping)


def test_a_grip_of_thirty_percent_less_slips_and_the_event_says_when_and_how_far(slipping):
    force_n = 0.7 * 2.1
    assert 2.0 * MU * force_n < WEIGHT_N
    scenario, traces = lifted(force_n)
    first = told(scenario, traces)[0]
    server, rows = traces.server, np.flatnonzero(slipping)
    assert (first["who"], first["kind"]) == ("box", "slip")
    assert first["time_s"] == pytest.approx(server.time_s[rows[0]], abs=0.1)
    assert "in the grip of user1 and user2" in first["what"]
    way_m = server.poses["user1"][:, 2] - server.poses["box"][:, 2]
    slid_mm = 1e3 * (way_m[rows[0] : rows[-1]].max() - way_m[rows[0]])
    assert float(first["what"].split()[2]) == pytest.approx(slid_mm, rel=0.1)
    found = summary(traces, scenario)
    lines = [line for line in found["verdict"] if line["text"].startswith("box, at")]
    assert [line["ok"] for line in lines] == [None]
    assert not [why for why in found["check"]["reasons"] if "box" in why]


def test_a_box_between_fingers_that_squeeze_too_little_slips_and_only_its_pose_tells():
    scenario, traces = simulated("lift", 4.0, **HASTE, **{"operator.squeeze": 0.9})
    (slip,) = told(scenario, traces)
    box, finger = (traces.server.poses[name][:, 2] for name in ("box", "pmwvc_user1"))
    away = np.flatnonzero(finger - box > 1e-3)[0]
    assert slip["time_s"] == pytest.approx(traces.server.time_s[away], abs=0.15)
    traces.server.poses.clear()
    assert not told(scenario, traces)


def test_a_box_that_is_let_go_falls_when_nobody_touches_it():
    scenario, traces = simulated("hand_over", 7.2, without=("user3", "user4"))
    (fall,) = (each for each in told(scenario, traces) if each["kind"] == "drop")
    server, half_m = traces.server, 0.5 * scenario.server.object_size_m
    box, *pads = (server.poses[name] for name in ("box", "user1", "user2"))
    off = np.all([np.abs(pad - box)[:, 0] >= half_m for pad in pads], axis=0)
    (free_s, *_) = server.time_s[off & (server.time_s > 6.0)]
    assert fall["who"] == "box"
    assert fall["time_s"] == pytest.approx(free_s, abs=0.1)
    assert "fell by" in fall["what"]
