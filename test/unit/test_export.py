# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""An exported session holds every signal of the recording, to the last bit, with its unit."""

import csv
from dataclasses import fields

import numpy as np
import pytest
from scipy.io import loadmat
from support import plain as scenarios
from support.simulated import simulated

from pmwvc_analysis.export import KINDS, declared, export, tables
from pmwvc_analysis.recording.from_traces import record_traces
from pmwvc_bringup.cli import main
from pmwvc_core.errors import PmwvcError, RecordingError
from pmwvc_core.traces import FateTraces, PacketTraces, ServerTraces, UserTraces


@pytest.fixture(scope="module")
def scenario():
    return scenarios.load("cube_3d", duration_s=0.6)


@pytest.fixture
def traces(scenario):
    return simulated(scenario)


def read_csv(file):
    with file.open(newline="") as stream:
        head, *rows = csv.reader(stream)
    return {name: [row[index] for row in rows] for index, name in enumerate(head)}


def test_every_signal_of_the_traces_has_a_column():
    owners = {"name", "topic", "link", "users", "tick_s", "period_s"}
    kept_otherwise = {  # blocks, accounts, energies, counts, poses, scene and contacts
        "block_time_s", "state", "reason", "energy", "missed", "safety_events", "accounts",
        "block_number", "epoch", "changes", "grid", "poses", "scene", "contacts", "contained",
        "orientation",
    }  # fmt: skip
    owners |= kept_otherwise
    for kind in (UserTraces, ServerTraces, PacketTraces, FateTraces):
        assert {field.name for field in fields(kind)} <= {*declared(kind), *owners}


def test_csv_holds_the_numbers_by_axis_and_their_units(tmp_path, scenario, traces):
    export(tmp_path / "new" / "csv", traces, scenario, kind="csv")
    found = read_csv(tmp_path / "new" / "csv" / "user1.csv")
    user, server = traces.users[0], traces.server
    np.testing.assert_array_equal(np.array(found["time_s"], float), user.time_s)
    for axis in range(3):
        values = np.array(found[f"f_applied_{axis + 1}"], float)
        np.testing.assert_array_equal(values, user.f_applied[:, axis])
    found = read_csv(tmp_path / "new" / "csv" / "server_user2.csv")
    np.testing.assert_array_equal(np.array(found["f_s_3"], float), server.f_s[1][:, 2])
    rows = read_csv(tmp_path / "new" / "csv" / "columns.csv")
    keys = zip(rows["table"], rows["column"], strict=True)
    units = dict(zip(keys, rows["unit"], strict=True))
    assert units["user1", "x_m_2"] == "m" and units["server", "kinetic"] == "J"
    files = {file.stem for file in (tmp_path / "new" / "csv").iterdir()}
    assert {table for table, _ in units} == files - {"columns", "parameters"}
    named = read_csv(tmp_path / "new" / "csv" / "parameters.csv")
    assert dict(zip(*named.values(), strict=True))["link.up.delay_s"] == "0.008"


def test_matrices_are_those_of_the_traces(tmp_path, scenario, traces):
    file = tmp_path / "session.mat"
    export(file, traces, scenario, kind="mat")
    content = loadmat(file, simplify_cells=True)
    parameters = dict(content["parameters"])
    assert content["units"]["user1"]["x_m"] == "m"
    assert parameters["master.impedance"] == 25.0 and parameters["scenario"] == "cube_3d"
    for table in tables(traces):
        for name, values in table.columns.items():
            np.testing.assert_array_equal(np.squeeze(content[table.name][name]), values.squeeze())


def test_the_command_writes_into_the_session_folder(tmp_path, scenario, traces, capsys):
    record_traces(tmp_path / "session", traces, scenario)
    assert main(["export", str(tmp_path / "session"), "--as", "mat"]) == 0
    assert capsys.readouterr().out == f"{tmp_path / 'session' / 'session.mat'}\n"
    recorded = loadmat(tmp_path / "session" / "session.mat", simplify_cells=True)
    np.testing.assert_allclose(recorded["user2"]["x_m"], traces.users[1].x_m, atol=1e-15)
    assert recorded["fates_user1_up"]["seq"][0] == 1


def test_what_cannot_be_written_is_refused_by_path(tmp_path, scenario, traces):
    (tmp_path / "taken").write_text("")
    for kind in KINDS:
        with pytest.raises(RecordingError, match=r"cannot write .*taken"):
            export(tmp_path / "taken" / "x", traces, scenario, kind=kind)
    with pytest.raises(PmwvcError, match="'xls': there are csv, mat"):
        export(tmp_path / "x", traces, scenario, kind="xls")
    assert main(["export", str(tmp_path / "nowhere")]) == 2
