# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The report of a scene: bodies by name, options written, no contact law that there is not."""

import re
from dataclasses import replace

import numpy as np
import pytest

from pmwvc_analysis.events.events import complete
from pmwvc_analysis.figures.motion_charts import forces, positions
from pmwvc_analysis.figures.recorded import conditions
from pmwvc_analysis.session_files import finish
from pmwvc_bringup.scenarios import load
from pmwvc_core.simulation.session import simulate


@pytest.fixture(scope="module")
def door():
    """A door pushed open past its latch."""
    scenario = replace(load("door"), duration_s=7.0)
    return simulate([scenario])[0], scenario


def lines(chart, axis):
    return {line.label: line.y for line in chart.panels[axis].lines}


def test_bodies_that_moved_are_drawn_by_name_and_others_are_not(door):
    traces, scenario = door
    drawn = lines(positions(traces, scenario), 1)
    assert list(drawn) == ["target", "door", "latch", "user1 device", "user1 avatar"]
    assert 1.5 < np.ptp(drawn["latch"]) < 20.0  # pressed in and back [mm]
    latch = traces.server.poses["latch"][:, 1] - traces.server.scene["origin"][1]
    np.testing.assert_allclose(drawn["latch"], latch[: len(drawn["latch"])] * 1e3, atol=1e-6)
    still = {name: rows[:100] for name, rows in traces.server.poses.items()}
    early = replace(traces, server=replace(traces.server, poses=still))
    assert "latch" not in lines(positions(early, scenario), 1)
    plain = replace(traces, server=replace(traces.server, scene={}))  # as recorded before
    assert "object" in lines(positions(plain, scenario), 1)


def test_an_axis_that_nothing_uses_is_drawn_as_zero(door):
    traces, scenario = door
    noise = 1e-10 * np.array([[0.0, 0.0, 1.0]])
    users = [replace(u, x_m=u.x_m + noise, f_applied=u.f_applied + noise) for u in traces.users]
    noisy = replace(traces, users=users)
    for chart in (positions(noisy, scenario), forces(noisy, scenario)):
        assert not any(np.nansum(np.abs(y)) for y in lines(chart, 2).values())
        assert all(np.any(y) for label, y in lines(chart, 0).items() if label != "target")


def test_the_note_has_no_contact_law_that_a_scene_does_not_have(door):
    for scenario, has in ((door[1], False), (load("carry_16ms"), True)):
        note = conditions(scenario, "simulated")
        assert (" K = " in note and " B = " in note) is has
        assert "delay 16/16 ms" in note


def test_the_report_says_what_was_written_into_the_model(door, tmp_path):
    scenario = replace(door[1], duration_s=0.4)
    (traces,) = simulate([scenario])
    found = []
    for scene in (traces.server.scene, {}):
        said = replace(traces, server=replace(traces.server, scene=scene))
        finish(tmp_path, said, scenario)
        page = (tmp_path / "report.html").read_text("utf-8")
        found += [re.findall(r"Scene options, written into the model[^<]*", page)]
    ((text,), nothing) = found
    assert ": cone elliptic, impratio 100.0, " in text
    assert not nothing


def test_a_torque_at_its_limit_is_named_in_newton_metres():
    """Recorded at the lever [N]; with 0.01 mN m allowed one soon is, by default none."""
    found = {}
    for torque_n_m in (1e-5, 0.0):
        settings = [f"safety.max_torque={torque_n_m}", "safety.soft_start_s=0.1"]
        scenario = load("turn", duration_s=6.0, settings_texts=settings)
        traces = simulate([scenario])[0]
        found[torque_n_m] = {e["what"] for e in complete(traces, scenario) if e["kind"] == "limit"}
        (contact, *_) = (
            e["what"] for e in complete(traces, scenario) if "contact made" in e["what"]
        )
        assert re.fullmatch(r"contact made; up to [\d.]+ N and [\d.]+ N m until .* s", contact)
        labels = [panel.y_label for panel in forces(traces, scenario).panels[:6]]
        assert (labels[0], labels[3]) == ("force, x [N]", "torque, about x [N m]")
    (text, *_) = found[1e-5]
    assert re.match(r"torque limited for [\d.]+ s: up to [\d.]+ N m commanded, 0.0000 N m", text)
    assert not any(text.startswith("torque") for text in found[0.0])
