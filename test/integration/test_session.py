# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Whole live sessions: ``./pmwvc run`` with real nodes, and the files of their folders."""

import json
import os
import signal
import subprocess

import numpy as np
import pytest
from std_srvs.srv import Trigger
from support.excuses import unless_stalled
from support.peers import ros
from support.processes import NodeProcess
from support.sessions import ROOT, Running
from support.simulated import judged, simulated
from support.starts import not_heard
from support.verdicts import judged_stable, stood_still

from pmwvc_analysis.recording.reader import read_session
from pmwvc_bringup.scenarios import load
from pmwvc_core.runtime.services import PUBLISHERS, SUBSCRIPTIONS, unmatched
from pmwvc_msgs.msg import Wave

pytestmark = pytest.mark.integration
USERS = ("user1", "user2")
UP, BEHIND = "/user1/wave_up", "/server/user1/wave_up"
KILLED = {"user2": "user2 master"}  # as the session names it


def test_a_session_ends_well_with_a_report(carried):
    assert carried.code == 0, carried.output()
    assert (carried.folder / "report.html").stat().st_size > 10_000
    assert carried.events() == []
    assert carried.summary()["source"] == "live"
    judged_stable(carried)


def test_a_session_is_announced_with_a_prediction_and_ends_with_a_verdict(carried):
    text = carried.output()
    assert "acts like a spring" in text
    with unless_stalled(lambda: stood_still(carried)):
        assert "carry_16ms: stable" in text, text
    assert f"report: {carried.folder}/report.html" in text


def test_a_session_leaves_no_process_and_no_shared_memory(carried):
    assert set(carried.seen) == {"recorder", "netem", "server", *USERS}
    assert carried.left == {}
    assert carried.shared_memory == {name: [] for name in carried.seen}


def test_everything_is_recorded_from_first_to_last_and_nothing_is_wrong_with_it(carried):
    words = [ROOT / "pmwvc", "doctor", carried.folder]
    result = subprocess.run(words, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout  # so nothing is missing, either
    traces = read_session(carried.folder)
    for user in traces.users:
        assert user.tick[0] == 0
        assert len(user.tick) + user.missed == user.tick[-1] + 1  # a busy machine may skip
    for topic in ("/user1/wave_up", "/server/user1/wave_up", "/user2/wave_down"):
        assert traces.packets[topic].seq[0] == 1
    assert traces.server.step[0] in (0, 1)


def test_the_budget_of_a_live_session_closes(carried):
    found = json.loads((carried.folder / "budget.json").read_text("utf-8"))
    assert found["closes"], found
    assert found["hands_j"] > 1e-4  # the hands have pressed
    if not found["notes"]:  # nothing is missing: to rounding, as in virtual time
        assert found["residual_largest_j"] < 1e-9
    assert "Energy budget" in (carried.folder / "report.html").read_text("utf-8")


def test_the_loops_run_at_their_rates(carried):
    for user in read_session(carried.folder).users:
        due = user.tick[-1] - user.tick[0]
        assert due / (user.time_s[-1] - user.time_s[0]) == pytest.approx(1000.0, rel=0.02)
        assert due + 1 == len(user.tick) + user.missed
        assert due > 3700  # and on until it is ended, which takes a busy machine longer
    for link in carried.summary()["links"]:
        assert link["delay_s"]["p50"] == pytest.approx(0.016, abs=0.001)
        assert link["lost"] == 0


def test_a_live_session_does_what_the_simulated_one_does(carried):
    """What differs is the lag: 4 ms by the phases of live loops, and what the playouts keep at
    hand for packets that were late here. It lengthens the delay spring; hands that close in by as
    much press less, by their springs in series over that of the contact.
    """
    scenario = load("carry_16ms", duration_s=4.0)
    live, ideal, longer = carried.summary(), judged(scenario), []
    traces, others = read_session(carried.folder), simulated(scenario)
    for index, user in enumerate(scenario.users):
        device_n, avatar_n, apart_m = settled(traces, index)
        other_n, other_avatar_n, other_apart_m = settled(others, index)
        sign, per_lag = -user.side, abs(other_n) / (2.0 * user.impedance)
        more = sign * (apart_m - other_apart_m)
        late_s = 2.0 * lateness_s(carried, user.name)
        hand = 1.0 / (1.0 / user.operator.stiffness + 1.0 / user.operator.grip_stiffness)
        softer = sign * hand / (1.0 + hand / user.contact.contact_stiffness) * more
        with unless_stalled(lambda: stood_still(carried)):  # then the grip is still settling
            assert per_lag * 0.004 - 5e-5 < more < per_lag * late_s + 0.001
            assert device_n == pytest.approx(other_n - softer, abs=0.05)
            assert avatar_n == pytest.approx(other_avatar_n - softer, abs=0.05)
        # a machine that stalls delays packets, and of a disturbance no more is claimed
        one, other = live["users"][index], ideal["users"][index]
        assert one["force_peak_n"] <= 1.5 * other["force_peak_n"]
        assert one["passive"] is other["passive"] is True
        longer.append(more)
    apart_m = 0.0005 + abs(longer[0] - longer[1])
    assert live["object"]["position_final_m"] == pytest.approx(
        ideal["object"]["position_final_m"], abs=apart_m
    )


def settled(traces, index):
    """Medians over the last 1.5 s, which no single stall of the machine moves: forces at device
    and avatar [N], distance from avatar to device [m].
    """
    user, server = traces.users[index], traces.server
    rows = user.time_s > user.time_s[-1] - 1.5
    steps = server.time_s > server.time_s[-1] - 1.5
    apart_m = np.median(user.x_m[rows, 0]) - np.median(server.x_s[index][steps, 0])
    avatar_n = np.median(server.f_s[index][steps, 0])
    return np.median(user.f_applied[rows, 0]), avatar_n, apart_m


def lateness_s(session, name):
    """Return how late loops and links of a user were at most, added up [s]: two waits as long make
    a margin as long.
    """
    traces = read_session(session.folder)
    found = float(np.max(traces.metadata["server_lateness_s"]))
    found += sum(user.lateness_s.max() for user in traces.users if user.name == name)
    links = [link for link in session.summary()["links"] if link["name"].startswith(name)]
    return found + sum(link["delay_s"]["max"] - link["delay_s"]["p50"] for link in links)


def test_a_recorder_that_stood_still_for_five_seconds_has_everything(tmp_path):
    disturbances = "disturbances=0.5 stop recorder; 5.5 continue recorder"
    words = ["--duration", 6.5, "--set", disturbances]
    with Running(tmp_path / "session", "carry_16ms", *words) as session:
        assert session.end() == 0, session.output()
        summary = session.summary()
        recording = summary["recording"]
    assert summary["interrupted"] == []  # nor is its time shifted by that
    assert set(recording["missing"].values()) == {0}
    assert recording["holes"] == []
    assert [event["kind"] for event in session.events()] == ["disturbance"] * 2


def test_the_session_folder_holds_what_is_needed_to_run_it_again(carried):
    names = {path.name for path in (carried.folder / "nodes").iterdir()}
    for node in carried.seen:
        assert {f"{node}.yaml", f"{node}.log"} <= names
    again = load(str(carried.folder / "scenario.yaml"))
    assert again == load("carry_16ms", duration_s=4.0)


def test_nodes_that_are_killed_are_named_and_the_others_go_on(tmp_path):
    """The recorder last; then the session is terminated, by SIGTERM: others by SIGINT."""
    nodes = ("user2", "server", "netem", "recorder")
    with Running(tmp_path / "session", "carry_16ms", "--duration", 600, figures=True) as session:
        session.await_ticks()
        kill(session, nodes[:-1])
        session.await_ticks()  # two seconds on
        kill(session, nodes[-1:])
        session.process.send_signal(signal.SIGTERM)
        assert session.end() == 0, session.output()
        assert_named(session, nodes)
        assert 2.0 < session.summary()["duration_s"] < 60.0
        report = (session.folder / "report.html").read_text("utf-8")
        for name in nodes:
            assert KILLED.get(name, name) in report and "ended by SIGKILL" in report


def kill(session, nodes):
    """Kill nodes; each is named, and the others run on."""
    left = session.nodes()
    for node in nodes:
        os.kill(left.pop(node), signal.SIGKILL)
        session.await_line(f"{KILLED.get(node, node)} was ended by SIGKILL")
        assert session.nodes() == left


def assert_named(session, nodes):
    """The nodes that were killed, and no others, are noted; none is left."""
    events = session.events()
    names = [KILLED.get(node, node) for node in nodes]
    assert [event["who"] for event in events] == names, (events, session.output())
    assert {event["signal"] for event in events} == {"SIGKILL"}
    assert session.nodes() == {}


def test_a_node_that_never_came_up_is_reported_with_its_last_output(tmp_path):
    words = ["--set", "user2.device.plugin=touch"]  # whose library is not here
    with Running(tmp_path / "session", "carry_16ms", *words) as session:
        assert session.end() == 1
        text = session.output()
        assert "user2 master exited with 2" in text
        assert "install the OpenHaptics SDK" in text.partition("user2 master exited")[2]
        assert session.nodes() == {}


def test_no_node_outlives_a_runner_that_is_killed(tmp_path):
    with Running(tmp_path / "session", "carry_16ms", "--duration", 600) as session:
        session.await_ticks()
        assert len(session.nodes()) == 5
        session.process.kill()
        session.await_no_nodes()


def test_two_sessions_at_once_receive_nothing_from_each_other(pair):
    for session in pair.values():
        assert session.code == 0, session.output()
        assert json.loads("".join(session.lines)) == session.summary()
        assert len({*read_session(session.folder).packets["/user1/wave_up"].epoch}) == 1


def test_a_node_that_waits_states_what_it_has_matched():
    with (
        ros() as peer,
        NodeProcess("pmwvc_netem.node", {"users": ["user1"], "start.paused": True}),
    ):

        def said():
            return json.loads(peer.call(Trigger, "/netem/matched", Trigger.Request()).message)

        before = said()
        assert (before[SUBSCRIPTIONS][UP], before[PUBLISHERS][BEHIND]) == (0, 0)
        assert unmatched(before, [UP, BEHIND]) == [
            f"{BEHIND}: no subscriber matched",
            f"{UP}: no publisher matched",
        ]
        publisher = peer.publisher(Wave, UP)
        peer.subscribe(Wave, BEHIND, lambda _: None)
        peer.until(publisher.get_subscription_count)
        peer.until(lambda: unmatched(said(), [UP, BEHIND]) == [])


def test_first_packet_of_every_end_arrives(carried):
    """Nobody speaks before every end has matched; so it is in the sessions of test_controllers."""
    traces = read_session(carried.folder)
    assert not_heard(traces) == set()
    fates = traces.fates["user2/down"]  # the control: the first packet came too early
    known = fates.seq > 1
    fates.epoch, fates.seq = fates.epoch[known], fates.seq[known]
    assert not_heard(traces) == {"user2/down", "/server/user2/wave_down"}
