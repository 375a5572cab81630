# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C at any instant of a start: one line, exit code 130, nothing left."""

import contextlib
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


def loads_view(session: int) -> bool:
    """Tell whether a view node of a session of processes has begun to load its modules."""
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            view = b"pmwvc_view.node" in (folder / "cmdline").read_bytes()
            if view and os.getsid(int(folder.name)) == session:
                return "_multiarray_umath" in mapped(int(folder.name))
    return False


# Instants of a start, by what the process has done so far: is Python, has loaded a module.
INSTANTS = {
    "interpreter": lambda pid: "python" in executed(pid),
    "imports": lambda pid: "lib-dynload" in mapped(pid),  # of the standard library
    "numpy": lambda pid: "_multiarray_umath" in mapped(pid),
    "linear algebra": lambda pid: "_umath_linalg" in mapped(pid),
}


@pytest.mark.parametrize(  # the commands differ once their own modules load
    ("command", "instant"), [*(("run", each) for each in INSTANTS), ("simulate", "linear algebra")]
)
def test_an_interrupt_while_modules_load_is_one_line(tmp_path, command, instant):
    words = [command, "carry_16ms", "--duration", "600", "--out", tmp_path / "session"]
    with subprocess.Popen(
        [ROOT / "pmwvc", *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        while not INSTANTS[instant](process.pid):
            assert process.poll() is None
        process.send_signal(signal.SIGINT)
        _, said = process.communicate()
    assert process.returncode == 130, said
    assert said in ("pmwvc: interrupted\n", "pmwvc: ended before the session began\n")


def test_an_interrupt_while_the_modules_of_a_node_load_ends_it():
    with subprocess.Popen(
        [ROOT / "pmwvc", "node", "view"],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    ) as process:
        while not loads_view(process.pid):
            assert process.poll() is None
        os.killpg(process.pid, signal.SIGINT)
        said, _ = process.communicate()
    assert process.returncode == 0, said
    assert "Traceback" not in said


@pytest.mark.parametrize("nodes", [0, 4])
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
