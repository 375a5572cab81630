# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Environments by name: what is installed, what is said of one that cannot be used; a plug-in is
asked in a thread: waited for, left alone while busy, asked again.
"""

import operator
import re
import sys
import textwrap
import threading
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from support.lab import offer
from support.law_rigs import Users

from pmwvc_core.errors import ParameterError
from pmwvc_core.law.black_box.touched import Wall
from pmwvc_core.made.server import object_of
from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.plugins import Unanswered
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.server import environments
from pmwvc_core.simulation.session import simulate
from pmwvc_server.asking import Worker, caller


def server_at(name, own=None):
    params = ServerParams(coupling="unknown", environment=name)
    return Users(params, [ContactParams()], of_environments=own)


class Honey:
    """An environment of somebody else."""

    def __init__(self, setup):
        self.users = setup.users

    def step(self, position, velocity, dt):
        return 4.0 * velocity


@pytest.fixture
def lab(monkeypatch):
    """A laboratory's own module with plug-ins, beside the library."""

    def broken(setup):
        raise OSError("no mesh file jelly.obj")

    def picky(setup):
        raise ParameterError("server.object_mass = 2.0: a jelly weighs less")

    found = {"honey": Honey, "stone": lambda _: object(), "broken": broken, "picky": picky}
    others = {"jelly": "lab_environments:Jelly", "wall": "lab_environments:stone"}
    offer(monkeypatch, environments.PLUGINS.group, "lab_environments", found, **others)


def test_environment_of_another_package_is_made_and_its_force_rendered(lab):
    server = server_at("honey")
    server.join(0, -0.03)
    for _ in range(200):
        server.step([1.0])
    assert server.f_s[0] == pytest.approx(4.0 * server.xd_s[0])
    assert server.xd_s[0] == pytest.approx((2.0 * 25.0) ** 0.5 / (25.0 + 4.0))


def test_the_library_goes_before_plug_ins_of_the_same_name(lab):
    assert isinstance(server_at("wall").s.body.environment, Wall)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("moon", r"= 'moon': not installed; there are: cube, wall, .*active_wall, .*honey"),
        ("broken", r"= 'broken' \(lab_.*cannot be made: OSError: no mesh file jelly.obj"),
        ("stone", r"= 'stone' \(lab_.*is not an environment: it lacks step"),
    ],
)
def test_a_plug_in_that_fails_is_named_with_the_reason(lab, name, text):
    with pytest.raises(ParameterError, match=rf"^server.environment {text}"):
        server_at(name)
    with pytest.raises(ParameterError, match=r"^server.object_mass = 2.0: a jelly weighs less$"):
        server_at("picky")  # what it states of its settings is passed on


@pytest.mark.parametrize("name", ["hunt_crossley", "active_wall", "honey"])
def test_another_coupling_than_unknown_names_what_to_set(name):
    text = rf"environment = '{name}': set server.coupling = unknown for it \(implicit supports"
    with pytest.raises(ParameterError, match=text):
        ServerParams(environment=name)
    with pytest.raises(ParameterError, match=r"needs controller = pmwvc with server.coupling"):
        object_of(ServerParams(environment=name, coupling="unknown"))


def test_a_simulated_session_goes_on_and_tells_what_failed(lab, monkeypatch):
    def melts(position, velocity, dt):
        raise RuntimeError("the jelly has melted")

    monkeypatch.setattr(Honey, "step", staticmethod(melts))
    values = {"name": "melting", "controller": "pmwvc", "channel": "plain", "users": 1}
    own = {"coupling": "unknown", "environment": "honey"}
    scenario = parse_scenario(values | {"duration_s": 0.4, "server": own})
    [traces] = simulate([scenario])
    assert traces.metadata["environment"] == {
        "contained_steps": str(len(traces.server.step)),
        "last_fault": "server.environment = 'honey' raised RuntimeError: the jelly has melted",
    }
    assert np.all(traces.server.v_s[0] == 0.0)
    assert set(traces.server.accounts) >= {"contained", "withheld", "tank", "granted"}


def documented():
    """Return the two environments of the documentation, as source."""
    text = (Path(__file__).resolve().parents[2] / "docs" / "environments.md").read_text("utf-8")
    jelly, meeting_wall = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    return jelly, "class Wall:\n" + textwrap.indent(meeting_wall, "    ")


def test_the_wall_of_the_documentation_is_as_stiff_as_it_says():
    found = {}
    exec(compile(documented()[1], "docs/environments.md", "exec"), found)
    wall = found["Wall"]()
    wall.x, wall.K, wall.B = np.zeros((1, 1)), 1e6, 0.0
    server = Users(ServerParams(coupling="unknown"), [ContactParams()], environment=wall)
    server.join(0, -0.03)
    for _ in range(100):
        server.step([1.0 / 50.0**0.5])  # 1 N
    assert server.f_s[0] == pytest.approx(1.0)
    assert wall.x.item() == pytest.approx(1e-6)
    assert server.x_s[0] == pytest.approx(-0.03 + 1e-6)


def test_the_environment_of_the_documentation_works(lab):
    source = documented()[0]
    lab_module = sys.modules["lab_environments"]
    exec(compile(source, "docs/environments.md", "exec"), vars(lab_module))
    server = server_at("jelly", SimpleNamespace(jelly=lab_module.JellyParams()))
    server.join(0, -0.04)
    for _ in range(2000):
        server.step([1.0 / 50.0**0.5])  # 1 N
    assert server.faults.steps == 0
    assert server.f_s[0] == pytest.approx(1.0)
    assert server.x_s[0] == pytest.approx(-0.04 + 1.0 / 100.0)
    assert server.energies["potential"] == pytest.approx(0.5 * 1.0**2 / 100.0)
    server.leave(0)
    server.step([0.0])
    assert server.faults.steps == 0
    assert server.energies["potential"] == 0.0


def test_what_comes_with_the_project_is_asked_directly_a_plug_in_through_a_thread():
    assert caller(ServerParams()) is operator.call
    assert caller(ServerParams(coupling="unknown", environment="hunt_crossley")) is operator.call
    assert isinstance(caller(ServerParams(coupling="unknown", environment="jelly")), Worker)


def test_an_answer_comes_back_from_another_thread():
    worker = Worker(30.0)
    assert worker(threading.current_thread) is not threading.current_thread()
    assert [worker(lambda n=n: n * n) for n in range(5)] == [0, 1, 4, 9, 16]


@pytest.mark.parametrize("error", [ZeroDivisionError("no mass"), SystemExit("bye")], ids=repr)
def test_what_the_environment_raises_is_raised_and_its_thread_goes_on(error):
    def fails():
        raise error

    worker = Worker(30.0)
    with pytest.raises(type(error), match=str(error)):
        worker(fails)
    assert worker(lambda: 7) == 7


def test_a_hanging_environment_is_left_alone_until_it_is_back_and_its_late_answer_is_dropped():
    release, asked = threading.Event(), []

    def hangs():
        release.wait()
        return "late"

    worker = Worker(0.001)
    with pytest.raises(Unanswered, match=r"has not answered within 1 ms"):
        worker(hangs)
    for _ in range(3):
        with pytest.raises(Unanswered, match=r"is still busy with the step of \d+\.\d+ s ago"):
            worker(lambda: asked.append(1))
    assert asked == []
    release.set()
    assert worker._answer.result(30.0) == "late"  # it is back
    worker._patience_s = 30.0
    assert worker(lambda: "new") == "new"


def test_a_scene_is_asked_by_the_loop_itself_until_it_is_slow():
    def who(busy_s):
        def exchange():
            end_s = time.thread_time() + busy_s
            while time.thread_time() < end_s:
                pass
            return threading.current_thread().name

        return exchange

    here = threading.current_thread().name
    assert caller(ServerParams(coupling="unknown", environment="mujoco"))(who(0.0)) == here
    ask = Worker(0.025).at_once
    assert {ask(who(busy_s)) for busy_s in (*(0.06, 0.0) * 4, 0.06, 0.06, 0.06)} == {here}
    assert ask(who(0.0)) == "environment"
