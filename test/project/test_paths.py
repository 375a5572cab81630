# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The files that a reader opens to follow a wave once around, or the sums of an energy budget.

Values are followed (``support.traced``). A wave passes the files whose functions return it, or
what is linear in it, from the wave port of the device to the cube and back to the force that the
device renders. Not counted: arithmetic (``numeric.py``), device and hand (``plant/``,
``motion.py``), and what gives the ends their times (``simulation/`` here, the nodes' loops live).
A budget is computed in the files whose functions are given an energy or return one.
"""

import contextlib
import re
from pathlib import Path

import numpy as np
import pytest
from support import traced

from pmwvc_analysis.budget.budget import budget
from pmwvc_bringup.scenarios import load
from pmwvc_core.frame.server_step import ServerStep
from pmwvc_core.plant.devices import SimulatedDevice
from pmwvc_core.simulation.session import SessionBatch, simulate_one
from pmwvc_core.wave.transform import WavePort

TABLE = (Path(__file__).resolve().parents[2] / "docs" / "architecture.md").read_text("utf-8")
UNCOUNTED = re.compile(r"pmwvc_core/(numeric\.py|motion\.py|plant/|simulation/)")
FIRST, LAST = 100, 112  # steps of the server that are watched
OF_USER = {
    1: ("x_m", "xd_m", "f_h", "f_m", "f_applied", "u_m", "u_m_lp", "v_m"),
    2: ("energy", "accounts"),
}
OF_SERVER = {
    1: ("x_o", "xd_o", "x_s", "xd_s", "f_s", "u_s", "v_s"),
    2: ("energy_u_s", "energy_v_s", "kinetic", "potential", "dissipated", "accounts"),
}


def passed(channel, monkeypatch, degree=1):
    """Return the files that a wave passes; none of them if it is not marked (``degree`` 0)."""
    one = load("carry_16ms", settings_texts=[f"channel={channel}", "users=1"], duration_s=1.0)
    batch = SessionBatch([one, one])
    formed, serve, moved = WavePort.u, ServerStep.tick, SimulatedDevice.step
    found = {}
    with contextlib.ExitStack() as watching:

        def tick(server, *arguments):
            if server.steps == FIRST:
                found.update(files=watching.enter_context(traced.files(1)))
            if server.steps == LAST:
                watching.close()
            return serve(server, *arguments)

        def step(device, *forces):  # the next motion is another lap
            return moved(device, *(np.asarray(force) for force in forces))

        monkeypatch.setattr(WavePort, "u", lambda *given: traced.traced(formed(*given), degree))
        monkeypatch.setattr(ServerStep, "tick", tick)
        monkeypatch.setattr(SimulatedDevice, "step", step)
        batch.run(lambda ratio: None)
    returned = {file for file, seen in found["files"].items() if seen["out"]}
    return {file for file in returned if not UNCOUNTED.match(file)}


def mark(record, names):
    for degree, own in names.items():
        for name in own:
            value = getattr(record, name)
            if isinstance(value, dict):
                value = {key: traced.traced(each, degree) for key, each in value.items()}
            else:
                value = traced.traced(value, degree)
            setattr(record, name, value)


def row(channel):
    """Return the files of a row of the table in the documentation."""
    found = re.search(rf"^\| {channel} \|.*$", TABLE, re.MULTILINE)
    return set(re.findall(r"`([\w/]+\.py)`", found[0]))


@pytest.mark.parametrize(("channel", "most"), [("strict", 12), ("plain", 12)])
def test_a_wave_passes_few_files_from_device_to_cube_and_back(channel, most, monkeypatch):
    files = passed(channel, monkeypatch)
    assert "pmwvc_core/server/cube.py" in files and "pmwvc_core/master/safety/limiter.py" in files
    assert len(files) <= most, sorted(files)
    assert {f"pmwvc_core/{file}" for file in row("both") | row(channel)} == files


def test_nothing_is_passed_by_a_wave_that_is_not_marked(monkeypatch):
    assert passed("plain", monkeypatch, degree=0) == set()


@pytest.mark.parametrize("channel", ["strict", "plain"])
def test_a_budget_is_summed_in_few_files(channel):
    one = load("carry_16ms", settings_texts=[f"channel={channel}"], duration_s=1.0)
    traces = simulate_one(one)
    for user in traces.users:
        mark(user, OF_USER)
    mark(traces.server, OF_SERVER)
    with traced.files(2) as found:
        assert budget(traces, one) is not None
    files = {file for file in found if file != "pmwvc_core/numeric.py"}
    assert "pmwvc_core/plant/devices.py" in files and "pmwvc_core/server/cube.py" in files
    assert len(files) <= 8, sorted(files)


def test_products_of_signals_are_energies_and_their_roots_are_not():
    signal = traced.traced(np.ones((2, 3)))
    energy = (signal * (2.0 * signal)).sum(axis=-1)
    assert (traced.degree_of(signal - 1.0), traced.degree_of(np.cumsum(energy))) == (1, 2)
    assert traced.degree_of(np.where(True, signal, 0.0)) == 1
    assert traced.degree_of(np.sqrt(energy)) == 0 == traced.degree_of(energy * energy)
