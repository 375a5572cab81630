# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The end of a node's process: by a signal in order, by a refusal in one line, else loudly; child
processes of a session end as they are told.
"""

import os
import signal
import sys
import threading
import time
from pathlib import Path

import pytest
from rich.console import Console
from std_msgs.msg import Bool
from support.processes import isolate

from pmwvc_bringup.scenarios import load
from pmwvc_bringup.session import runner
from pmwvc_bringup.session.processes import Children
from pmwvc_core.errors import DeviceError
from pmwvc_core.params import MasterParams
from pmwvc_core.runtime.parameters import declare
from pmwvc_core.runtime.process import run_node

WITHIN_S = 30.0


class Work:
    """Work that does what a test wants, and remembers what became of it."""

    def __init__(self, run=lambda stop: None, build=lambda node: None):
        self._run, self._build = run, build
        self.happened = []

    def __call__(self, node):
        self._build(node)
        return self

    def run(self, stop):
        self.happened.append("run")
        self._run(stop)

    def close(self):
        self.happened.append("close")


def run(work, *ros_args):
    isolate()
    arguments = ["--ros-args", *ros_args] if ros_args else []
    return run_node("tried", work, args=arguments)


def fail(error):
    def failing(*_):
        raise error

    return failing


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_asks_the_work_to_stop_and_is_a_good_end(number):
    def signalled(stop):
        os.kill(os.getpid(), number)
        assert stop.wait(WITHIN_S)

    before = signal.getsignal(number)
    work = Work(signalled)
    assert run(work) == 0
    assert work.happened == ["run", "close"]
    assert signal.getsignal(number) == before


def test_an_unusable_setting_is_reported_in_one_line(capfd):
    work = Work(fail(DeviceError("no device\nplug one in")))
    assert run(work) == 2
    assert work.happened == ["run", "close"]
    assert capfd.readouterr().err.splitlines() == ["tried: no device plug one in"]


def test_an_unknown_parameter_is_refused_and_the_work_let_go(capfd):
    work = Work(build=lambda node: declare(node, "master", MasterParams))
    assert run(work, "-p", "master.impedence:=1.0") == 2
    assert work.happened == ["close"]
    assert "did you mean master.impedance?" in capfd.readouterr().err


def test_arguments_that_ros_cannot_read_are_refused(capfd):
    assert run(Work(), "--no-such-argument") == 2
    assert "--no-such-argument" in capfd.readouterr().err
    assert run(Work(), "--params-file", "/no/such/file") == 2
    assert "/no/such/file" in capfd.readouterr().err


@pytest.mark.parametrize("where", ["run", "build"])
def test_a_mistake_of_ours_shows_its_traceback(where, capfd):
    work = Work(**{where: fail(ZeroDivisionError("ours"))})
    assert run(work) == 1
    assert "Traceback" in capfd.readouterr().err
    assert work.happened == (["run", "close"] if where == "run" else [])


def test_a_mistake_in_a_service_ends_the_work(capfd):
    def with_timer(node):
        node.create_timer(0.001, fail(ZeroDivisionError("ours")))

    work = Work(run=lambda stop: stop.wait(WITHIN_S), build=with_timer)
    assert run(work) == 1
    assert work.happened[-1] == "close"  # it may end even before it runs
    assert "ZeroDivisionError: ours" in capfd.readouterr().err


def test_a_paused_node_that_is_stopped_never_runs():
    stopper = threading.Timer(0.0, lambda: os.kill(os.getpid(), signal.SIGINT))
    work = Work(build=lambda node: stopper.start())
    assert run(work, "-p", "start.paused:=true") == 0
    assert work.happened == ["close"]


@pytest.mark.parametrize(("listeners", "heard"), [(0, False), (1, False), (2, True)])
def test_a_node_that_joins_begins_once_its_trace_is_heard(listeners, heard):
    def build(node):
        node.create_publisher(Bool, "~/trace", 1)
        for _ in range(listeners):
            node.create_subscription(Bool, "~/trace", lambda _: None, 1)
        if not heard:
            threading.Timer(0.0, lambda: os.kill(os.getpid(), signal.SIGINT)).start()

    work = Work(build=build)
    assert run(work, "-p", "start.joins:=true", "-p", "start.listeners:=2") == 0
    assert work.happened == (["run", "close"] if heard else ["close"])


@pytest.mark.parametrize("words", [["nonsense"], ["-p", "master.impedance:=20.0"]])
def test_words_in_front_of_the_ros_arguments_are_refused(words, capfd):
    isolate()
    assert run_node("tried", Work(), args=[*words, "--ros-args", "-p", "a:=1"]) == 2
    message = capfd.readouterr().err
    assert message.startswith(f"tried: {' '.join(words)}: not understood; ")
    assert "--ros-args -p name:=value" in message


# A child that says so when it is ready, and obeys or refuses SIGINT and SIGTERM. It wakes again
# and again: a signal right before signal.pause() would be lost on it.
OBEYS = "import time\nprint('ready', flush=True)\nwhile True: time.sleep(0.01)"
REFUSES = (
    "import signal\n"
    "for n in (signal.SIGINT, signal.SIGTERM): signal.signal(n, signal.SIG_IGN)\n"
    "print('ready', flush=True)\n"
    "while True: signal.pause()"
)


def started(children: Children, name: str, code: str, folder: Path):
    child = children.start(
        name, [sys.executable, "-c", code], env=os.environ, log=folder / f"{name}.log"
    )
    while not child.has_logged("ready"):
        assert child.running, child.log_tail()
        time.sleep(0.01)
    return child


@pytest.fixture
def children():
    group = Children()
    yield group
    group.kill()


@pytest.mark.parametrize("ignored", [False, True])
def test_a_child_that_obeys_ends_by_the_first_signal(children, tmp_path, ignored):
    """A shell lets a background command ignore SIGINT; its children must not inherit that."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN if ignored else signal.SIG_DFL)
    try:
        child = started(children, "one", OBEYS, tmp_path)
        assert child.log_tail() == "ready"
        child.process.send_signal(signal.SIGSTOP)  # it is woken to obey
        (ended,) = children.stop(["one"])
        assert (ended.name, ended.code) == ("one", -signal.SIGINT)
        assert children.running() == []
    finally:
        signal.signal(signal.SIGINT, before)


@pytest.mark.parametrize("hurried", [False, True])
def test_a_child_that_refuses_is_killed(children, tmp_path, monkeypatch, hurried):
    short = ((signal.SIGINT, 0.05), (signal.SIGTERM, 0.05), (signal.SIGKILL, 5.0))
    if not hurried:
        monkeypatch.setattr("pmwvc_bringup.session.processes.STOP_SIGNALS", short)
    started(children, "stubborn", REFUSES, tmp_path)
    (ending,) = children.stop(["stubborn"], hurried=lambda: hurried)
    assert ending.signal == "SIGKILL"


def test_an_ending_is_reported_once_with_signal_or_code(children, tmp_path):
    killed = started(children, "one", OBEYS, tmp_path)
    killed.process.kill()
    command = [sys.executable, "-c", "raise SystemExit(3)"]
    exited = children.start("two", command, env=os.environ, log=tmp_path / "log")
    for child in (killed, exited):
        child.process.wait()
    ended = [str(ending) for ending in children.endings()]
    assert ended == ["one was ended by SIGKILL", "two exited with 3"]
    assert children.endings() == children.stop(["one", "two"]) == []


def test_an_interrupt_that_a_library_swallowed_ends_a_session_before_it_begins(
    tmp_path, monkeypatch
):
    for came in ([], [signal.SIGINT]):
        monkeypatch.setattr(runner, "INTERRUPTS", came)
        session = runner.NodeSession(load("carry_16ms"), tmp_path, console=Console())
        assert session.interrupts.count == len(came)
