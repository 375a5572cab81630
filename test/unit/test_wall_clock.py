# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A wall clock that jumps changes no force, no packet and no deadline: loops, links and receivers
read the monotonic clock. The wall clock is for stamps of messages and names of folders alone.
"""

import ast
import itertools
import time
from pathlib import Path

import pytest
from support.loop_rig import TICKS, Rig

from pmwvc_core.runtime.pacing import Pacer

ROOT = Path(__file__).resolve().parents[2]
CONTROL = ("pmwvc_core/pmwvc_core", "pmwvc_master", "pmwvc_server", "pmwvc_netem")
# Files that stamp messages with the wall clock. ``wave_topics`` also finds by it how long a packet
# waited in the middleware, for the report of its delay: bounded, and no part of control.
STAMPS = {
    "pmwvc_core/pmwvc_core/runtime/process.py",
    "pmwvc_core/pmwvc_core/runtime/watch.py",
    "pmwvc_core/pmwvc_core/runtime/topics.py",
    "pmwvc_master/pmwvc_master/devices/ros_topic.py",
    "pmwvc_master/pmwvc_master/node.py",
    "pmwvc_netem/pmwvc_netem/node.py",
    "pmwvc_server/pmwvc_server/node.py",
    "pmwvc_server/pmwvc_server/wires.py",
}
HOUR_NS = 3600 * 10**9


@pytest.fixture
def jumping(monkeypatch):
    """The wall clock of this process jumps by hours, forwards and back, at every look."""
    jumps = itertools.cycle((0, 5 * HOUR_NS, -7 * HOUR_NS))
    true_ns = time.time_ns
    monkeypatch.setattr(time, "time_ns", lambda: true_ns() + next(jumps))
    monkeypatch.setattr(time, "time", lambda: (true_ns() + next(jumps)) * 1e-9)


def frames():
    """Run a force loop for a while; return its forces and packets."""
    rig = Rig()
    for grid in range(TICKS * 40):
        if grid % TICKS == 4:
            rig.answer(0.2)
        rig.tick(grid)
    return rig.device.forces, rig.wires.sent


CALM = frames()


def test_forces_and_packets_are_the_same_while_the_wall_clock_jumps(jumping):
    assert abs(time.time_ns() - time.time_ns()) > HOUR_NS
    assert frames() == CALM


def test_a_loop_on_the_wall_clock_would_miss_deadlines(jumping):
    """The control: the pacer of the loops, on either clock."""
    for clock, misses in ((time.monotonic_ns, False), (time.time_ns, True)):
        pacer = Pacer(10**9, clock=clock, sleep=lambda _: None)
        assert any(pacer.wait().skipped for _ in range(6)) == misses


def test_nothing_but_stamps_reads_the_wall_clock():
    found = set()
    for room in CONTROL:
        for file in (ROOT / room).rglob("*.py"):
            for node in ast.walk(ast.parse(file.read_text("utf-8"))):
                name = ast.unparse(node) if isinstance(node, ast.Attribute) else ""
                if name in ("time.time", "time.time_ns") or name.endswith("get_clock"):
                    found.add(file.relative_to(ROOT).as_posix())
    assert found == STAMPS
