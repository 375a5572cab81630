# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The findings of the doctor in recordings."""

import json
import shutil

import numpy as np
import pytest
from support import handmade
from support import plain as files

from pmwvc_analysis.doctor import PROBLEM, WARNING, check_recording, exit_code
from pmwvc_analysis.recording.from_traces import record_traces
from pmwvc_analysis.traces.consistency import inconsistencies
from pmwvc_bringup import machine
from pmwvc_core.simulation.session import simulate_one


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("session")
    record_traces(place, handmade.session(duration_s=0.8), handmade.scenario(duration_s=0.8))
    return place


def recorded(place, traces):
    record_traces(place, traces, handmade.scenario(duration_s=traces.duration_s))
    return check_recording(place)


def texts(findings, status):
    return "\n".join(finding.text for finding in findings if finding.status == status)


def kept(traces, rows):
    """Keep some rows of packets or fates."""
    for name, values in vars(traces).items():
        if isinstance(values, np.ndarray):
            setattr(traces, name, values[rows])


def test_a_sound_recording_is_sound(folder):
    findings = check_recording(folder)
    assert {finding.check for finding in findings} == {"file", "missing", "physics"}
    assert exit_code(findings) == 0


def test_packets_that_are_missing_are_told_from_those_that_a_link_lost(tmp_path):
    traces = handmade.session(duration_s=0.8)
    rows = np.delete(np.arange(100), [10, 11])
    kept(traces.packets["/user2/wave_up"], rows)
    kept(traces.packets["/server/user1/wave_up"], np.delete(np.arange(98), [10, 11]))
    traces.fates["user1/up"].fate[10], traces.fates["user1/up"].time_out_ns[10] = 1, 0
    findings = recorded(tmp_path / "a", traces)
    assert "/user2/wave_up: 2 of 100 missing" in texts(findings, WARNING)
    assert "1 packets that user1/up delivered" in texts(findings, WARNING)
    assert exit_code(findings) == 2


@pytest.mark.parametrize(
    ("break_it", "words"),
    [
        (lambda t: t.users[0].u_m.__imul__(1.01), "user1: u_m is not sqrt(2b) xd - v_m"),
        (lambda t: t.server.f_s[0].__imul__(1.01), "user1: F is not sqrt(b/2) (u - v) at the s"),
        (lambda t: t.server.energy_u_s[1].__imul__(1.01), "user2: the energy of u_s"),
        (lambda t: t.users[0].x_m.__setitem__(50, np.nan), "user1: x_m has 1 values"),
    ],
)
def test_physics_that_does_not_add_up_is_a_problem(tmp_path, break_it, words):
    traces = handmade.session(duration_s=0.8)
    break_it(traces)
    findings = recorded(tmp_path / "a", traces)
    assert words in texts(findings, PROBLEM)
    assert exit_code(findings) == 3


def test_a_force_that_safety_limited_does_not_count_against_the_port():
    noisy = ("device.encoder_step_m=5.5e-5", "device.velocity=euler")
    scenario = files.load("carry_16ms", settings_texts=noisy, duration_s=4.0)
    traces = simulate_one(scenario)
    user = traces.users[0]
    natural = np.sqrt(2 * scenario.users[0].impedance) * user.xd_m - user.v_m
    shortened = np.flatnonzero(np.abs(user.u_m - natural) > 1e-3)
    same_force = (np.abs(user.f_applied - user.f_m) < 1e-9)[shortened]
    assert (~same_force).any()  # limited
    assert same_force.any()  # and ticks that cover the deficit
    assert inconsistencies(traces, scenario) == []
    # the control: another wave before any limit
    user.u_m[: shortened[0]] *= 0.9
    user.energy["u_m"] = np.cumsum(user.u_m[:, 0] ** 2)[7::8] * user.tick_s / 2
    assert any("u_m is not sqrt(2b) xd" in line for line in inconsistencies(traces, scenario))


def test_what_a_recording_lacks_or_stopped_early_is_a_warning(folder, tmp_path):
    shutil.copy(folder / "session.mcap", tmp_path)
    event = {"time_s": 0.5, "who": "recorder", "what": "recording stopped: no space"}
    (tmp_path / "events.json").write_text(json.dumps([event]))
    findings = check_recording(tmp_path)
    assert "rosbag2 cannot open" in texts(findings, WARNING)
    assert "recording stopped: no space" in texts(findings, WARNING)
    assert exit_code(findings) == 2


def test_a_cut_file_is_damaged_and_looked_at_as_far_as_it_is_whole(folder, tmp_path):
    damaged = tmp_path / "damaged"
    shutil.copytree(folder, damaged)
    data = (damaged / "session.mcap").read_bytes()
    (damaged / "session.mcap").write_bytes(data[: int(0.8 * len(data))])
    (damaged / "metadata.yaml").unlink()
    findings = check_recording(damaged)
    assert "it was not closed" in texts(findings, PROBLEM)
    assert any(finding.check == "physics" for finding in findings)  # still looked at
    assert exit_code(findings) == exit_code(check_recording(tmp_path / "nowhere")) == 3


def test_elsewhere_than_on_linux_only_what_works_there_is_checked(monkeypatch):
    monkeypatch.setattr(machine.platform, "system", lambda: "Darwin")
    found = {finding.check: finding for finding in machine.examine()}
    assert list(found) == ["python", "system", "disk"]
    assert found["system"].status == machine.OK
    assert "live sessions need Linux" in found["system"].text
