# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A really recorded session, replayed: ``./pmwvc run``, then ``./pmwvc replay`` of its folder.

The links lose, copy and reorder packets, and the rates change while it runs.
"""

import json
import re
import signal
import subprocess
from dataclasses import replace

import numpy as np
import pytest
from geometry_msgs.msg import PointStamped
from support.processes import ros
from support.sessions import ROOT, Running

from pmwvc_analysis.recording.reader import read_scenario, read_session
from pmwvc_analysis.replay.run import POSITION_M
from pmwvc_core.runtime.topics import WAVE_QOS
from pmwvc_core.simulation.session import simulate_one
from pmwvc_msgs.msg import MasterTrace, ServerTrace

pytestmark = pytest.mark.integration


# From a step of the server on, parameters of a node; a recorder that a busy machine starts late
# listens by then.
CHANGES = [
    (400, "/user1/master", {"master.rate_drop": 20}),
    (500, "/server", {"server.period_s": 0.005}),
    (600, "/user2/master", {"master.rate_drop": 5}),
]


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A live session over a bad network, long enough for changes where nodes are found late."""
    folder = tmp_path_factory.mktemp("recorded") / "session"
    link = {"delay_s": 0.012, "jitter": "uniform", "jitter_s": 0.006, "loss": 0.05}
    link |= {"duplicate": 0.05, "keep_order": "false"}
    words = [word for name, value in link.items() for word in ("--set", f"link.{name}={value}")]
    with Running(folder, "carry_16ms", "--duration", 10, *words) as session:
        with ros(domain=domain_of(session)) as peer:
            steps = peer.collect(ServerTrace, "/server/trace")
            for step, node, values in CHANGES:
                peer.until(lambda: (steps and steps[-1].step > step) or session.process.poll())  # noqa: B023
                assert peer.set_parameters(node, values) == [""]
        assert session.end() == 0, session.output()
    return folder


def domain_of(session):
    return int(re.search(r"ROS_DOMAIN_ID=(\d+)", session.await_line("ROS_DOMAIN_ID"))[1])


def pmwvc(*words):
    result = subprocess.run(
        [ROOT / "pmwvc", *map(str, words)], capture_output=True, text=True, check=False
    )
    return result.returncode, result.stdout, result.stderr


def replayed(recorded, out, *words):
    code, text, errors = pmwvc("replay", recorded, "--out", out, "--json", *words)
    assert code == 0, errors
    return json.loads(text)


def assert_paused(found):
    """The force of a hand is not known in ticks that did not run: the first one is named."""
    for limit in found["limits"]:
        assert "ticks that did not run is interpolated" in limit["why"]
    assert found["exact"] is False
    assert found["limits"][0]["why"] in found["lead"]


@pytest.mark.parametrize("hand", ["operator", "force"])
def test_a_replay_is_the_recording_to_the_last_bit(recorded, tmp_path, hand):
    found = replayed(recorded, tmp_path / "again", "--hand", hand, "--no-figures")
    if hand == "force" and found["limits"]:
        assert_paused(found)
        return
    assert found["limits"] == []
    assert found["exact"] is True, found["differences"]
    assert "is exact" in found["lead"]
    assert [user["name"] for user in found["differences"]] == ["user1", "user2"]
    for user in found["differences"]:
        assert user["ticks"] > 3500
        assert user["force_max_n"] == user["position_max_m"] == 0.0
    assert "server.period_s=0.005" in " ".join(found["notes"])
    assert min(session["force_peak_n"] for session in found["sessions"]) > 1.0


def test_a_simulation_over_a_worse_network_does_not(recorded):
    """The control: fates of packets that matter move the devices by more than the tolerance.

    The same losses for other packets need not: they are made up for.
    """
    traces, scenario = read_session(recorded), read_scenario(recorded)
    worse = [
        replace(
            user,
            link_up=replace(user.link_up, loss=0.6),
            link_down=replace(user.link_down, loss=0.6),
        )
        for user in scenario.users
    ]
    other = simulate_one(replace(scenario, users=tuple(worse)))
    for one, two in zip(traces.users, other.users, strict=True):
        shared = min(len(one.tick), len(two.tick))
        if np.abs(one.x_m[:shared] - two.x_m[:shared]).max() > 2.0 * POSITION_M:
            return
    raise AssertionError("no device moved otherwise")


def test_a_replay_with_another_impedance_is_a_session_of_its_own(recorded, tmp_path):
    found = replayed(recorded, tmp_path / "stiffer", "--set", "master.impedance=40")
    assert found["changes"] == {"master.impedance": [25.0, 40.0]}
    assert found["reproduced"] is None
    recorded_apart, replayed_apart = (s["coherency_rms_m"] for s in found["sessions"])
    assert replayed_apart < 0.8 * recorded_apart  # the link is a stiffer spring: 2b/tau
    summary = json.loads((tmp_path / "stiffer" / "summary.json").read_text("utf-8"))
    assert summary["source"] == "replayed"
    assert summary["parameters"]["master.impedance"] == 40.0
    before, after = read_session(recorded).fates, read_session(tmp_path / "stiffer").fates
    left_ns = min(before[f"{user}/up"].time_in_ns[-1] for user in ("user1", "user2"))
    for link, fates in before.items():
        shared = len(after[link].fate)  # the recorded server runs on after the users have left
        assert (fates.time_in_ns < left_ns).sum() - 5 <= shared <= len(fates.fate)
        lost, lost_again = (int((each.fate[:shared] == 1).sum()) for each in (fates, after[link]))
        assert lost > 5
        assert lost_again == pytest.approx(lost, abs=1)  # numbers are shifted by what began first
    assert "data:image/png" in (tmp_path / "stiffer" / "comparison.html").read_text("utf-8")
    assert pmwvc("doctor", tmp_path / "stiffer")[0] == 0
    code, text, _ = pmwvc("report", tmp_path / "stiffer", "--json")
    assert (code, json.loads(text)["source"]) == (0, "replayed")


def test_live_sessions_are_compared_side_by_side(tmp_path):
    out = tmp_path / "compared"
    words = ["--over", "link.delay_s=0.004,0.08", "--duration", "3", "--set", "task.grip_s=0.1"]
    code, text, errors = pmwvc("compare", "wall", *words, "--live", "--out", out, "--json")
    assert code == 0, errors
    found = json.loads(text)
    assert [session["source"] for session in found["sessions"]] == ["live", "live"]
    near, far = (session["coherency_rms_m"] for session in found["sessions"])
    assert near < far
    assert (out / "comparison.html").is_file()
    for session in found["sessions"]:
        assert (out / session["folder"] / "report.html").is_file()


def test_a_hand_from_outside_and_a_change_in_flight_are_recorded_and_replayed(tmp_path):
    """The test is the pointer: it drags user1's handle, and makes the contact stiffer."""
    folder, settings = tmp_path / "session", ("user1.operator.kind=remote", "task.kind=hold")
    words = [word for setting in settings for word in ("--set", setting)]
    with Running(folder, "carry_16ms", "--duration", 250, *words) as session:
        with ros(domain=domain_of(session)) as peer:
            target = peer.node.create_publisher(PointStamped, "/user1/hand/target", WAVE_QOS)
            peer.until(lambda: target.get_subscription_count() >= 2)  # master and recorder
            drag(peer, target)
        session.process.send_signal(signal.SIGINT)
        assert session.end() == 0, session.output()
    traces = read_session(folder)
    assert len(traces.targets["user1"].time_s) > 50
    assert {"server.contact_stiffness": 1500.0} in [values for _, values in traces.settings]
    exact = replayed(folder, tmp_path / "exact", "--hand", "force", "--no-figures")
    if exact["limits"]:
        assert_paused(exact)
    else:
        assert exact["exact"] is True
    found = replayed(folder, tmp_path / "again", "--no-figures")
    (limit,) = found["limits"]  # how late a target reached the hand is up to the machine
    assert "the tick at which a target reached the hand" in limit["why"]
    assert found["exact"] or limit["why"] in found["lead"]
    peak, again = (each["force_peak_n"] for each in found["sessions"])
    assert again == pytest.approx(peak, rel=0.2)
    assert found["sessions"][0]["force_peak_n"] > 0.5
    assert any("parameters change as recorded" in note for note in found["notes"])


def drag(peer, target):
    """Publish a target every two frames, to 8 mm inside the face; make it stiffer on the way."""
    blocks = peer.collect(MasterTrace, "/user1/trace")
    for count in range(200):
        seen = len(blocks)
        peer.until(lambda: len(blocks) >= seen + 2)  # noqa: B023
        message = PointStamped()
        message.point.x = -0.03 + 0.008 * min(1.0, count / 120)
        target.publish(message)
        if count == 75:
            stiff = {"server.contact_stiffness": 1500.0}
            assert peer.set_parameters("/server", stiff) == [""]
