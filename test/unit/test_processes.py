# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Child processes: nothing outlives a session, whatever happens to it."""

import os
import signal
import sys
import time
from pathlib import Path

import pytest
from rich.console import Console

from pmwvc_bringup.scenarios import load
from pmwvc_bringup.session import runner
from pmwvc_bringup.session.processes import Children

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
