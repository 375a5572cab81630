# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A box that slips in a grip or falls out of it: told from the recording, against what the scene
knows of itself. A pad slips where its force along the face is mu F.
"""

import numpy as np
import pytest

from pmwvc_analysis.events.events import complete
from pmwvc_analysis.verdicts.verdicts import summary
from pmwvc_bringup.scenarios import find, read
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.scenes import body
from pmwvc_core.simulation.session import simulate_one

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
        newest["slips"] = ((np.linalg.norm(along, axis=1) > 0.999 * most) & (most > 0.0))[pads]
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
