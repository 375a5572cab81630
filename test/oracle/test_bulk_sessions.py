# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Sessions in bulk are those of virtual time, and compiled they are the same.

The golden traces of every law in bulk: ``test_golden_traces.py``.
"""

import hashlib
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml
from support import golden

from pmwvc_core import compiled, unrolled
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.simulation.bulk import run as bulk
from pmwvc_core.simulation.bulk.run import can_run, run, session
from pmwvc_core.simulation.session import simulate, simulate_one
from pmwvc_core.simulation.traces import traces_of

CONFIG = Path(__file__).resolve().parents[2] / "pmwvc_bringup" / "config"


CASES = [("wifi_bursty", "strict"), ("blackout_2s", "zeroing")]
OUTAGE = {"blackout_2s": {"link.schedule": "0.8 outage; 1.3 base"}}


@pytest.mark.parametrize(("name", "channel"), CASES)
def test_a_session_in_bulk_is_that_of_virtual_time(name, channel):
    mapping = yaml.safe_load((CONFIG / f"{name}.yaml").read_text("utf-8"))
    of = {"channel": channel, "duration_s": 2.0}
    scenario = parse_scenario(mapping | of, overrides=OUTAGE.get(name, {}))
    left = run(scenario, session)
    assert left.whole
    was, now = golden.record_of(simulate_one(scenario)), golden.record_of(traces_of(left))
    assert golden.differences(was, now, 1e-10) == []


@pytest.fixture
def nothing_marked(monkeypatch):
    """A home in which no kind of session is marked as compiled, whatever this process has compiled
    before. What the same sources of laws and compiler gave is kept: half a minute.
    """

    def forget():
        compiled.kept_in.cache_clear()
        compiled.compiled.cache_clear()

    compiler = hashlib.sha256()
    for module in (compiled, unrolled):
        compiler.update(Path(module.__file__).read_bytes())
    home = CONFIG.parents[1] / ".pytest_cache" / "compiled" / compiler.hexdigest()[:16]
    monkeypatch.setenv("HOME", str(home))
    forget()
    for file in compiled.kept_in().iterdir():
        if file.is_file():
            file.unlink()
    yield
    forget()


def test_many_sessions_of_a_kind_are_compiled_once_and_are_those_stepped_alone(
    nothing_marked, monkeypatch, caplog
):
    monkeypatch.setattr(bulk, "COMPILING_TICKS", 3000)
    monkeypatch.setattr(bulk, "LOADING_TICKS", 1500)
    mapping = yaml.safe_load((CONFIG / "carry_16ms.yaml").read_text("utf-8"))
    mapping |= {"channel": "strict", "users": 1, "duration_s": 2.0}
    mapping["task"] |= {"grip_s": 0.05, "grip_rise_s": 0.3, "move_s": 0.5}
    many = [parse_scenario(mapping | {"server.contact_damping": b}) for b in (5.0, 10.0)]
    few = [parse_scenario(mapping | {"controller": "virtual_coupling"})]
    found = simulate([*many, *few])
    for scenario, traces in zip([*many, *few], found, strict=True):
        was = golden.record_of(simulate_one(scenario))
        assert golden.differences(was, golden.record_of(traces), 1e-10) == []
        assert np.abs(traces.users[0].f_applied).max() > 0.5
    (said,) = caplog.messages  # not of the plain one: it takes less than compiling
    assert "compiling" in said
    assert bulk.loops_of(many)[0] is not None and bulk.loops_of(few) == [None]


def test_a_scene_is_never_compiled():
    """What is outside Python's laws is no tuple of numbers; without it a cube is (the control)."""
    mapping = yaml.safe_load((CONFIG / "lift.yaml").read_text("utf-8"))
    assert not can_run(parse_scenario(mapping))
    assert can_run(parse_scenario(mapping | {"server": {"environment": "cube"}}))


def test_what_is_kept_depends_on_the_laws_of_hands_and_devices_too(nothing_marked, monkeypatch):
    read = []
    monkeypatch.setattr(Path, "read_bytes", lambda file: read.append(file.name) or b"")
    compiled.kept_in.cache_clear()
    compiled.kept_in()
    assert {"user_tick.py", "device.py", "hand.py", "loop.py"} <= set(read)


def test_a_compiled_loop_is_kept_for_later_processes_by_the_sources_of_the_laws(tmp_path):
    program = (
        "from pmwvc_core.compiled import compiled\n"
        "from pmwvc_core.plant.forces import minimum_jerk\n"
        "made = compiled(minimum_jerk, kept=True)\n"
        "print(made(0.25), sum(made.stats.cache_hits.values()))"
    )
    environment = {"HOME": str(tmp_path), "PATH": "/usr/bin:/bin"}
    for hits in (0, 1):
        found = subprocess.run(
            [sys.executable, "-c", program], env=environment, capture_output=True, text=True
        )
        assert found.stdout.split() == ["0.103515625", str(hits)], found.stderr
    assert len(list((tmp_path / ".cache" / "pmwvc").iterdir())) == 1
