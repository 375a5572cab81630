# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Faults: disturbances of a live session, what receivers count of a link's faults, the page."""

import signal
import sys
import time
from pathlib import Path

import pytest
from faults.groups import GROUPS
from faults.processes import PROCESSES
from faults.sessions import SESSIONS
from support import plain as scenarios

from pmwvc_bringup.session import plan
from pmwvc_bringup.session.events import Disturber
from pmwvc_bringup.session.processes import Children
from pmwvc_core.errors import ParameterError, ScenarioError
from pmwvc_core.scenario.conflicts import disturbances_of

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
        whos = ["server", "user1 master", "user1 master", "server"]
        assert [who for who, _, _ in events] == whos
        assert {kind for _, kind, _ in events} == {"disturbance"}
    finally:
        children.kill()


def test_every_fault_has_its_place_on_the_page():
    known = {fault.number for fault in (*SESSIONS, *GROUPS, *PROCESSES)}
    assert {number[:3] for number in known} == {f"F{n:02}" for n in range(1, 28)}
    lines = PAGE.read_text("utf-8").splitlines()
    rows = [line.split("|")[1].strip() for line in lines if line.startswith("| F")]
    assert rows == sorted(known)
