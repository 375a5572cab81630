# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Faults: disturbances of a live session, what receivers count of a link's faults, the page."""

import signal
import sys
import time
from collections import Counter
from pathlib import Path

import pytest
from faults.groups import GROUPS
from faults.processes import PROCESSES
from faults.sessions import SESSIONS
from support import plain as scenarios

from pmwvc_analysis.compare.probes import free_space
from pmwvc_analysis.models.stability import radii
from pmwvc_bringup.session import plan
from pmwvc_bringup.session.events import Disturber
from pmwvc_bringup.session.processes import Children
from pmwvc_core.errors import ParameterError, ScenarioError
from pmwvc_core.network.in_flight import Cause, FateKind
from pmwvc_core.scenario.conflicts import disturbances_of
from pmwvc_core.simulation.session import SteppedSession
from pmwvc_core.transport.packet import Receipt

PAGE = Path(__file__).resolve().parents[2] / "docs" / "faults.md"
SLEEPER = [sys.executable, "-c", "import time; time.sleep(60)"]


@pytest.mark.parametrize(
    "text, message",
    [
        ("6 shoot server", "entry 1 '6 shoot server': must be TIME ACTION NODE, kill or start"),
        ("6 kill", "must be TIME ACTION NODE"),
        ("6 kill printer", "'printer': must be server, netem, recorder or a user"),
        ("7 kill server; 6 start server", "entry 2 .* time = 6: must be 7..86400 s"),
        ("soon kill server", "time = soon: must be 0..86400 s"),
        ("6 kill user3", "kill user3 at 6 s: there is no user3"),
    ],
)
def test_disturbances_that_cannot_be_are_refused_with_value_and_range(text, message):
    with pytest.raises(ScenarioError, match=message):
        scenarios.load("carry_16ms", settings_texts=[f"disturbances={text}"])
    if "user3" not in text:
        with pytest.raises(ParameterError, match=message):
            disturbances_of(text)
    found = disturbances_of("6 kill server; 7.5 start server;")
    assert list(map(str, found)) == ["kill server at 6 s", "start server at 7.5 s"]


def test_what_is_done_to_a_user_leaves_the_prediction_as_it_is():
    disturbed, calm = (
        scenarios.load("carry_16ms", settings_texts=[f"disturbances={text}"])
        for text in ("8 kill user2; 10 start user2", "")
    )
    assert radii(disturbed)[0] == radii(calm)[0]
    assert free_space(disturbed) == free_space(calm)


def test_nodes_are_killed_stopped_continued_and_started_when_it_is_time(tmp_path, monkeypatch):
    monkeypatch.setattr(plan.NodePlan, "command", lambda self, file: SLEEPER)
    nodes = plan.nodes(scenarios.load("carry_16ms"), folder=tmp_path)
    children, events = Children(), []
    chosen = [node for node in nodes if node.kind in ("server", "master")]
    try:
        for node in chosen:
            children.start(node.name, SLEEPER, env={}, log=tmp_path / f"{node.file_name}.log")
        wanted = disturbances_of("1 kill server; 2 stop user1; 3 continue user1; 4 start server")
        rig = {"nodes": nodes, "children": children, "environment": {}, "logs": tmp_path}
        disturber = Disturber(wanted, **rig, note=lambda *event: events.append(event))
        server, master = children.children["server"], children.children["user1 master"]
        disturber.act(0.5)
        assert events == [] and server.running
        disturber.act(1.0)
        assert server.process.returncode == -signal.SIGKILL and master.running
        assert children.endings() == []  # it was wanted
        for time_s, letter in ((2.0, "T"), (3.0, "S")):
            disturber.act(time_s)
            stat = Path(f"/proc/{master.process.pid}/stat")
            while stat.read_text().rsplit(")", 1)[1].split()[0] not in letter + "R"[: time_s > 2]:
                time.sleep(0.001)
        disturber.act(9.0)
        assert children.children["server"].running and children.children["server"] is not server
        parameters = (tmp_path / "server_again1.yaml").read_text()
        assert "paused: false" in parameters and "joins: true" in parameters
        assert disturber.again == ["/server"]
        whos = ["server", "user1 master", "user1 master", "server"]
        assert [who for who, _, _ in events] == whos
        assert {kind for _, kind, _ in events} == {"disturbance"}
    finally:
        children.kill()


@pytest.mark.parametrize("channel", ["strict", "plain"])
def test_receivers_count_what_links_do(channel):
    """F08, F09: order, duplicates, corruption and gaps, to the last packet."""
    settings = ["link.reorder=0.3", "link.duplicate=0.2", "link.corrupt=0.05", "link.loss=0.1"]
    words = [f"channel={channel}", "duration_s=2", "link.keep_order=false", *settings]
    batch = SteppedSession(scenarios.load("carry_16ms", settings_texts=words))
    batch.run(lambda ratio: None)
    for user in batch.users:
        for way in (user.up, user.down):
            counts = way.receiver.counts
            out = sorted((f for f in way.fates if f.time_due_ns), key=lambda f: f.time_due_ns)
            came = out[: sum(counts.values())]  # the others were still under way
            assert len(out) - len(came) < 10
            newest, seen, expected = 0, set(), Counter()
            for fate in came:
                verdict = Receipt.ACCEPTED
                if fate.cause is Cause.CORRUPTION:
                    verdict = Receipt.CORRUPTED
                elif fate.number in seen:
                    verdict = Receipt.DUPLICATE
                elif fate.number < newest:
                    verdict = Receipt.REORDERED
                if verdict is not Receipt.CORRUPTED:
                    newest = max(newest, fate.number)
                    seen.add(fate.number)
                expected[verdict] += 1
            expected[Receipt.NEW_EPOCH] += 1  # the first one
            expected[Receipt.ACCEPTED] -= 1
            assert {v: n for v, n in counts.items() if n} == dict(expected)
            first = next(f.number for f in came if f.cause is not Cause.CORRUPTION)
            numbers = {number for number in seen if number >= first}
            assert way.receiver.lost == newest - first + 1 - len(numbers)
            lost = {f.number for f in way.fates if f.kind is FateKind.LOST}
            assert len(lost) == way.link.counters.lost > 5


def test_every_fault_has_its_place_on_the_page():
    known = {fault.number for fault in (*SESSIONS, *GROUPS, *PROCESSES)}
    assert {number[:3] for number in known} == {f"F{n:02}" for n in range(1, 28)}
    lines = PAGE.read_text("utf-8").splitlines()
    rows = [line.split("|")[1].strip() for line in lines if line.startswith("| F")]
    assert rows == sorted(known)
