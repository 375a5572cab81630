# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc transparency``: the document, the files, and what it says when it cannot answer."""

import csv
import dataclasses
import json

import numpy as np
import pytest
from support.command_line import ROOT, here

from pmwvc_analysis.transparency.answer import sentences
from pmwvc_analysis.transparency.transparency import Rendering
from pmwvc_bringup.cli import main

FELT = {
    "admittance_dc", "k_felt", "b_felt", "mass_felt", "b_free", "first_peak_hz",
}  # fmt: skip


def run(*words):
    return here(*words, cwd=ROOT)


def test_json_is_one_document_with_the_documented_keys():
    done = run("transparency", "carry_16ms", "--json")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    others = {"scenario", "user", "axis", "source", "ideal", "notes"}
    assert set(found) == FELT | others
    assert set(found["ideal"]) == FELT
    assert found["k_felt"] * found["admittance_dc"] == pytest.approx(1.0)
    assert found["k_felt"] < found["ideal"]["k_felt"]
    assert any("Grip" in note for note in found["notes"])


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("nowhere",), "nowhere"),
        (("direct_16ms",), "not stable"),
        (("wall", "--set", "device.friction=0.3", "--out", "curves"), "friction"),
        (("wall", "--user", "user7"), "there are user1"),
    ],
)
def test_what_has_no_answer_is_reported_with_exit_code_2(words, message, capfd):
    assert main(["transparency", *words]) == 2
    said = capfd.readouterr()
    assert message in said.err
    assert said.out == ""


def test_where_no_linear_model_holds_simulated_sessions_measure_and_that_is_said():
    """Passivity control renders the wall as it is at rest, and its damper in free motion."""
    words = ("transparency", "wall", "--set", "controller=tdpa", "--json")
    found = json.loads(run(*words).stdout)
    assert found["source"] == "measured"
    assert found["k_felt"] == pytest.approx(1000.0, rel=1e-3)
    assert found["b_free"] == pytest.approx(9.0, rel=0.01)
    assert "(controller = tdpa). Measured in simulated sessions: stiffness" in found["notes"][0]
    nothing = dataclasses.asdict(Rendering())
    found = dict(nothing, user="user1", source="law", ideal=nothing, notes=[])
    assert sentences(found) == ["user1, through the link: unknown", "ideal: unknown"]


def test_curves_come_as_picture_and_table(tmp_path):
    assert main(["transparency", "wall", "--out", str(tmp_path)]) == 0
    said = json.loads((tmp_path / "transparency.json").read_text("utf-8"))
    with (tmp_path / "transparency.csv").open() as file:
        rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
    size = np.hypot(rows[0]["admittance_real"], rows[0]["admittance_imag"])
    assert size == pytest.approx(said["admittance_dc"], rel=1e-2)
    assert (tmp_path / "transparency.png").read_bytes().startswith(b"\x89PNG")
    assert "<svg" in (tmp_path / "transparency.svg").read_text("utf-8")


def test_an_axis_is_asked_for_by_its_number(capfd):
    assert main(["transparency", "cube_3d", "--set", "channel=plain", "--axis", "2"]) == 0
    said = capfd.readouterr().out
    assert "user1, through the link: stiffness 362.7 N/m" in said  # along axis 1 it is 402 N/m
    assert "Along axis 2 of 3, the other axes free." in said
    for axis in ("0", "4"):
        assert main(["transparency", "cube_3d", "--axis", axis]) == 2
        assert f"--axis {axis}: must be 1 to 3 (dof)" in capfd.readouterr().err
