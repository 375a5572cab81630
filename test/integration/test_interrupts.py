# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C at any instant of a start: one line, exit code 130, nothing left."""

import os
import signal
import subprocess
from pathlib import Path

import pytest
from support.sessions import ROOT, Running

pytestmark = pytest.mark.integration


def mapped(pid: int) -> str:
    try:
        return Path(f"/proc/{pid}/maps").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return ""


def executed(pid: int) -> str:
    try:
        return os.readlink(f"/proc/{pid}/exe")
    except FileNotFoundError:
        return ""


# Instants of a start, by what the process has done so far: is Python, has loaded a module.
INSTANTS = {
    "interpreter": lambda pid: "python" in executed(pid),
    "imports": lambda pid: "_struct" in mapped(pid) or "_socket" in mapped(pid),
    "numpy": lambda pid: "_multiarray_umath" in mapped(pid),
    "linear algebra": lambda pid: "_umath_linalg" in mapped(pid),
}


@pytest.mark.parametrize("words", [["run", "carry_16ms"], ["simulate", "carry_16ms"]])
@pytest.mark.parametrize("instant", INSTANTS)
def test_an_interrupt_while_modules_load_is_one_line(tmp_path, words, instant):
    with subprocess.Popen(
        [ROOT / "pmwvc", *words, "--duration", "600", "--out", tmp_path / "session"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        while not INSTANTS[instant](process.pid):
            assert process.poll() is None
        process.send_signal(signal.SIGINT)
        _, said = process.communicate()
    assert process.returncode == 130, said
    assert said in ("pmwvc: interrupted\n", "pmwvc: ended before the session began\n")


@pytest.mark.parametrize("nodes", [0, 1, 3, 5])
def test_an_interrupt_while_nodes_start_is_one_line_and_leaves_none(tmp_path, nodes):
    with Running(tmp_path / "session", "carry_16ms", "--duration", 600) as session:
        session.await_line("ROS_DOMAIN_ID")
        while len(session.nodes()) < nodes:
            assert session.process.poll() is None
        session.process.send_signal(signal.SIGINT)
        assert session.end() == 130, session.output()
        assert session.nodes() == {}
        assert session.output().count("pmwvc: ended before the session began\n") == 1
        assert "Traceback" not in session.output()
