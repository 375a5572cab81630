# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Really recorded sessions, replayed: ``./pmwvc run``, then ``./pmwvc replay`` of the folder.

The links of one lose, copy and reorder packets, and the rates change while it runs; a hand of the
other is led from outside.
"""

import json
import signal
import subprocess
from dataclasses import replace

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped
from support.peers import ros
from support.sessions import ROOT, Running

from pmwvc_analysis.doctor import check_recording
from pmwvc_analysis.recording.reader import read_scenario, read_session
from pmwvc_analysis.replay.run import POSITION_M, exact, replay
from pmwvc_analysis.session_files import finish
from pmwvc_core.runtime.topics import WAVE_QOS
from pmwvc_core.simulation.session import simulate_one
from pmwvc_msgs.msg import MasterTrace

pytestmark = pytest.mark.integration


@pytest.fixture(scope="module")
def recorded(impaired):
    """The folder of a live session over a bad network."""
    assert impaired.code == 0, impaired.output()
    return impaired.folder


def pmwvc(*words):
    result = subprocess.run(
        [ROOT / "pmwvc", *map(str, words)], capture_output=True, text=True, check=False
    )
    return result.returncode, result.stdout, result.stderr


def replayed(recorded, out, *words):
    code, text, errors = pmwvc("replay", recorded, "--out", out, "--json", *words)
    assert code == 0, errors
    return json.loads(text)


def assert_exact(traces, scenario, hand):
    """Every tick is the same to the last bit, up to one that did not run: the force of a hand is
    not known there.
    """
    found = replay(traces, scenario, scenario, hand=hand)
    ran = [np.diff(user.tick) == 1 for user in traces.users]
    if all(each.all() for each in ran):
        assert exact(found.differences), found.differences
        return
    pairs = zip(traces.users, ran, strict=True)
    slept_s = min(user.time_s[each.argmin()] for user, each in pairs if not each.all())
    firsts = [user["first_s"] for user in found.differences]
    assert all(first is None or first > slept_s for first in firsts), firsts


def test_a_replay_is_the_recording_to_the_last_bit(recorded, tmp_path):
    found = replayed(recorded, tmp_path / "again", "--hand", "operator", "--no-figures")
    assert found["exact"] is True, found["differences"]
    assert "is exact" in found["lead"]
    assert [user["name"] for user in found["differences"]] == ["user1", "user2"]
    for user in found["differences"]:
        assert user["ticks"] > 3500
        assert user["force_max_n"] == user["position_max_m"] == 0.0
    assert "server.period_s=0.005" in " ".join(found["notes"])
    assert min(session["force_peak_n"] for session in found["sessions"]) > 1.0


def test_a_replay_by_the_forces_of_the_hands_is_the_recording_to_the_last_bit(recorded):
    assert_exact(read_session(recorded), read_scenario(recorded), "force")


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
    length_s = traces.duration_s  # the session was interrupted
    other = simulate_one(replace(scenario, users=tuple(worse), duration_s=length_s))
    pairs = [(one.x_m, two.x_m) for one, two in zip(traces.users, other.users, strict=True)]
    shared = [(min(len(x), len(y)), x, y) for x, y in pairs]
    assert max(np.abs(x[:n] - y[:n]).max() for n, x, y in shared) > 2.0 * POSITION_M


def test_a_replay_with_another_impedance_is_a_session_of_its_own(recorded, tmp_path):
    settings = ("--set", "master.impedance=40", "--no-figures")
    found = replayed(recorded, tmp_path / "stiffer", *settings)
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
        assert lost_again == pytest.approx(lost, abs=5)  # rows may be shifted by as many
    assert [each for each in check_recording(tmp_path / "stiffer") if each.status != "ok"] == []
    assert finish(tmp_path / "stiffer", figures=False)["source"] == "replayed"  # judged anew


def test_a_hand_from_outside_and_a_change_in_flight_are_recorded_and_replayed(tmp_path):
    """The test is the pointer: it drags user1's handle, and makes the contact stiffer."""
    folder, settings = tmp_path / "session", ("user1.operator.kind=remote", "task.kind=hold")
    words = [word for setting in settings for word in ("--set", setting)]
    with Running(folder, "carry_16ms", "--duration", 250, *words) as session:
        with ros(domain=session.domain()) as peer:
            target = peer.node.create_publisher(PoseStamped, "/user1/hand/target", WAVE_QOS)
            peer.until(target.get_subscription_count)
            drag(peer, target)
        session.process.send_signal(signal.SIGINT)
        assert session.end() == 0, session.output()
    traces = read_session(folder)
    assert len(traces.targets["user1"].time_s) > 50
    assert {"user1.server.contact_stiffness": 1500.0} in [values for _, values in traces.settings]
    scenario = read_scenario(folder)
    assert_exact(traces, scenario, "force")
    assert_exact(traces, scenario, "operator")  # each target in the tick that took it
    found = replayed(folder, tmp_path / "again", "--no-figures")
    peak, again = (each["force_peak_n"] for each in found["sessions"])
    assert again == pytest.approx(peak, rel=0.2)
    assert found["sessions"][0]["force_peak_n"] > 0.5
    assert any("parameters change as recorded" in note for note in found["notes"])


def drag(peer, target):
    """Publish targets at 60 Hz, as a page does, to 8 mm inside the face; make it stiffer on the
    way. By a timer, which does not catch up: a burst would leave only its last ones in the queue.
    """
    blocks, sent = peer.collect(MasterTrace, "/user1/trace"), []

    def move():
        sent.append(PoseStamped())
        sent[-1].pose.position.x = -0.03 + 0.008 * min(1.0, len(sent) / 120)
        target.publish(sent[-1])

    peer.until(lambda: blocks)
    timer = peer.node.create_timer(1.0 / 60.0, move)
    peer.until(lambda: len(sent) >= 75)
    stiff = {"user1.server.contact_stiffness": 1500.0}
    assert peer.set_parameters("/server", stiff) == [""]
    peer.until(lambda: len(sent) >= 200)
    peer.node.destroy_timer(timer)
