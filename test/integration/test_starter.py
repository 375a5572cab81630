# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A launched session, in a namespace: its nodes begin together and its time counts from there."""

import contextlib
import os
import subprocess
import sys

import numpy as np
import pytest
import yaml
from support.live_pages import opened
from support.page_sockets import Page
from support.processes import NodeProcess, isolate, ros
from visualization_msgs.msg import MarkerArray

from pmwvc_analysis.recording.reader import read_session
from pmwvc_bringup import scenarios
from pmwvc_bringup.session import plan
from pmwvc_bringup.session.monitor import watching
from pmwvc_core.frame import Presence

pytestmark = pytest.mark.integration
NAMESPACE, LENGTH_S = "/lab", 3.0
LINKS = ("user1/up", "user1/down", "user2/up", "user2/down")


def test_launched_nodes_begin_together_in_any_namespace_and_run_for_their_time(tmp_path):
    isolate()
    scenario = scenarios.load("carry_16ms", duration_s=LENGTH_S)
    file = tmp_path / "scenario.yaml"
    file.write_text(scenarios.to_yaml(scenario), "utf-8")
    with contextlib.ExitStack() as running:
        peer = running.enter_context(ros())
        scenes = peer.collect(MarkerArray, f"{NAMESPACE}/markers")
        nodes = {}
        for node in plan.nodes(scenario, folder=tmp_path, paused=True, page=plan.Page()):
            given = yaml.safe_load(node.parameter_file())["/**"]["ros__parameters"]
            where = f"{NAMESPACE}/{node.namespace}".rstrip("/")
            process = NodeProcess(
                plan.MODULES[node.kind], given, arguments=["-r", f"__ns:={where}"]
            )
            nodes[node.name] = running.enter_context(process)
        starter = subprocess.run(
            [
                *(sys.executable, "-m", "pmwvc_bringup.session.starter", str(file)),
                *("--duration", str(LENGTH_S), "--namespace", NAMESPACE),
            ],
            env=os.environ,
            capture_output=True,
            text=True,
        )
        assert (starter.returncode, starter.stderr) == (0, "")
        assert "the session begins" in starter.stdout
        peer.until(lambda: scenes)
        address = nodes["view"].await_output(r"^page http://127\.0\.0\.1:\d+/\?token=").split()[1]
        with opened(address) as socket:
            refused = Page(socket, "").ask("restart", values={})
        assert not refused["done"] and "can be started again from its page" in refused["text"]
        master = f"{NAMESPACE}/user1/master"
        assert peer.set_parameters(master, {"safety.max_force": 2.5}) == [""]
        (refusal,) = peer.set_parameters(master, {"safety.max_force": 3.0})
        assert "can only be lowered while running (now 2.5 N)" in refusal
        for kind in ("view", "user1 master", "user2 master", "server", "netem", "recorder"):
            with opened(address) if kind == "view" else contextlib.nullcontext() as socket:
                code = nodes[kind].stop()
                if socket:
                    ended = Page(socket, "").await_kind("ended")
                    assert ended["report"] == str(tmp_path / "report.html")
            assert (kind, code) == (kind, 0), nodes[kind].output
            assert "Traceback" not in nodes[kind].output
    traces = read_session(tmp_path)
    assert [user.name for user in traces.users] == ["user1", "user2"]
    for user in traces.users:
        ran_s = int(user.tick[-1]) * user.tick_s  # ticks count from the master's first
        assert ran_s >= LENGTH_S - 0.1
    # Nobody was pushed against alone: both were there before anyone touched the cube.
    together = np.all(np.equal(traces.server.state, Presence.COUPLED), axis=0)
    touched = np.any(traces.server.contact, axis=0)
    assert np.flatnonzero(together)[0] < np.flatnonzero(touched)[0]
    # Every node was there when the first one sent.
    assert {link: fates.seq[0] for link, fates in traces.fates.items()} == dict.fromkeys(LINKS, 1)
    (change,) = [event for event in traces.events if event.get("kind") == "parameter"]
    assert (change["who"], change["what"]) == ("user1 master", "safety.max_force set to 2.5 N")
    assert change["time_s"] >= LENGTH_S - 0.1


def test_a_starter_that_waits_ends_quietly_when_interrupted(tmp_path):
    isolate()
    file = tmp_path / "scenario.yaml"
    file.write_text(scenarios.to_yaml(scenarios.load("wall")), "utf-8")
    command = [sys.executable, "-m", "pmwvc_bringup.session.starter", str(file)]
    starter = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=os.environ)
    try:
        with ros() as peer:  # it is in the graph: it waits for nodes that never come
            peer.until(lambda: "runner" in peer.node.get_node_names())
        starter.terminate()
        assert starter.communicate(timeout=30)[1] == ""
        assert starter.returncode == 0
    finally:
        starter.kill()
        starter.wait()


@pytest.mark.parametrize("restarts", [False, True])
def test_page_finds_somebody_who_begins_again_only_where_somebody_does(restarts):
    isolate()
    with watching(["user1"], restarts=restarts) as monitor:
        assert monitor._node.count_subscribers("/view/restart") == restarts
