# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Environments of another package behind a real server node: one that raises, one that hangs."""

import base64
import contextlib
import json
import os
import sys
import threading

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from std_msgs.msg import String
from support.peers import ros
from support.processes import NodeProcess
from support.scenes import CONFIG, scene

from pmwvc_core.params import DeviceParams, OperatorParams
from pmwvc_core.runtime.topics import LATCHED_QOS, RECORDED_QOS
from pmwvc_msgs.msg import MasterTrace, ServerTrace
from pmwvc_view.description import moving
from pmwvc_view.live import topics
from pmwvc_view.live.topics import scene_of

pytestmark = [pytest.mark.integration]

PACKAGE = """
import time


class Damper:
    def __init__(self, setup):
        self.count = 0

    def step(self, position, velocity, dt):
        self.count += 1
        self.act()
        return 5.0 * velocity


class Raising(Damper):
    def act(self):
        if self.count % 100 > 50:
            raise RuntimeError("the jelly has melted")


class Hanging(Damper):
    def act(self):
        if self.count > 100:
            time.sleep(3600.0)
"""
ENTRY_POINTS = """[pmwvc.environments]
raising = lab_environments:Raising
hanging = lab_environments:Hanging
"""


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """A laboratory's package, as an installer leaves it."""
    (tmp_path / "lab_environments.py").write_text(PACKAGE)
    info = tmp_path / "lab_environments-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: lab-environments\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(ENTRY_POINTS)
    path = os.pathsep.join(filter(None, [str(tmp_path), os.environ.get("PYTHONPATH", "")]))
    monkeypatch.setenv("PYTHONPATH", path)


def nodes(stack, environment):
    """Start a server with an environment, and a master whose user pushes with 1 N."""
    server = {
        "channel": "plain",
        "users": ["user1"],
        "server.coupling": "unknown",
        "server.environment": environment,
    }
    master = {
        "channel": "plain",
        "side": -1,
        "operator": OperatorParams(kind="constant", force=1.0),
        "device": DeviceParams(damping=20.0, workspace_m=5.0),
    }
    ends = [f"wave_{way}:=/server/user1/wave_{way}" for way in ("up", "down")]
    arguments = ["-r", "__ns:=/user1", "-r", ends[0], "-r", ends[1]]
    found = stack.enter_context(NodeProcess("pmwvc_server.node", server))
    stack.enter_context(NodeProcess("pmwvc_master.node", master, arguments=arguments))
    return found


@pytest.mark.parametrize(
    ("environment", "text"),
    [
        ("raising", r"'raising' raised RuntimeError: the jelly has melted"),
        ("hanging", r"'hanging' (is still busy with the step of|has not answered within 4 ms)"),
    ],
)
def test_an_environment_that_fails_is_named_and_the_server_goes_on(installed, environment, text):
    with contextlib.ExitStack() as stack:
        peer = stack.enter_context(ros())
        steps, blocks = [], []
        for kind, topic, kept in (
            (ServerTrace, "/server/trace", steps),
            (MasterTrace, "/user1/trace", blocks),
        ):
            peer.node.create_subscription(kind, topic, kept.append, RECORDED_QOS)
        statuses = peer.collect(DiagnosticArray, "/diagnostics")
        server = nodes(stack, environment)
        server.await_output(text)

        def values():
            found = [s for array in statuses for s in array.status if s.name == "/server"]
            return {pair.key: pair.value for pair in found[-1].values} if found else {}

        def accounts(step):
            return dict(zip(step.account_names, step.accounts, strict=True))

        peer.until(lambda: int(values().get("environment: steps contained", 0)) > 60)
        count, last = len(steps), steps[-1].step
        peer.until(lambda: len(steps) >= count + 250)  # two seconds on
        assert steps[-1].step - last == len(steps) - count
        assert accounts(steps[-1])["contained"] > accounts(steps[count])["contained"] >= 0.0
        damped = [s for s in steps[count:] if s.v_s[0] == 0.0 and s.u_s[0] != 0.0]
        assert damped
        assert all(s.f_s[0] == pytest.approx(25.0 * s.xd_s[0]) for s in damped)
        peer.until(lambda: blocks and blocks[-1].state == MasterTrace.COUPLED)
        assert "environment" in values()["environment: last fault"]
        assert server.stop() == 0


def test_a_scene_is_described_once_for_whoever_comes_later():
    file = CONFIG / "lift.xml"
    with contextlib.ExitStack() as stack:
        peer = stack.enter_context(ros())
        server = {
            "dof": 3, "users": ["user1", "user2"], "server.coupling": "unknown",
            "server.environment": "mujoco", "server.scene": str(file),
        }  # fmt: skip
        stack.enter_context(NodeProcess("pmwvc_server.node", server))
        peer.until(lambda: peer.node.count_publishers("/server/trace"))
        texts, lost = [], []
        peer.node.create_subscription(String, "/server/scene", texts.append, LATCHED_QOS)
        peer.node.create_subscription(String, "/server/scene", lost.append, 1)  # the control
        peer.until(lambda: texts)
        (text,), asked = texts, scene(file).description
        assert json.loads(text.data) == asked
        assert base64.b64decode(asked["files"]["lift.xml"]) == file.read_bytes()
        assert not lost


@contextlib.contextmanager
def served(peer, failures):
    """Serve a node in a thread of its own, as nodes are."""
    ended = threading.Event()

    def serve():
        try:
            while not ended.is_set():
                peer.until(iter([False, True]).__next__)
        except Exception as error:  # ends the node
            failures.append(error)

    thread, usual_s = threading.Thread(target=serve), sys.getswitchinterval()
    sys.setswitchinterval(1e-6)  # what may happen between two lines does
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()
        sys.setswitchinterval(usual_s)


def test_a_page_takes_a_description_while_its_node_is_served_and_what_is_none_is_not_taken(
    monkeypatch,
):
    """A reader that goes under an executor which waits for it ended the page's node."""
    scene = {"shapes": [{"body": "box"}, {"body": "table"}], "fixed": {"table": [0] * 7}}
    none = ["", "{", "[1]", "null", '{"shapes": [1]}', '{"shapes": [{"body": "box"}]}']
    assert moving(scene) == ["box"]
    failures = []
    with ros() as peer, served(peer, failures):
        for number, text in enumerate([json.dumps(scene), *none]):
            topic = f"/server{number}/scene"
            publisher = peer.node.create_publisher(String, topic, LATCHED_QOS)
            publisher.publish(String(data=text))
            assert scene_of(peer.node, topic) == (scene if number == 0 else {})
        peer.node.create_publisher(String, "/silent/scene", LATCHED_QOS)
        monkeypatch.setattr(topics, "LOOK_S", 0.0)
        for number in range(500):
            monkeypatch.setattr(topics, "SCENE_S", 1e-5 * number)  # to go at any moment
            assert scene_of(peer.node, "/silent/scene") == {}
    assert failures == []
