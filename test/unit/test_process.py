# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The end of a node's process: by a signal in order, by a refusal in one line, else loudly."""

import os
import signal
import threading

import pytest
from std_msgs.msg import Bool
from support.processes import isolate

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
