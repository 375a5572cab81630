# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Figures: what they show, and that they stand for themselves."""

import dataclasses
import struct
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from support import handmade

from pmwvc_analysis.budget.energy import user_energies
from pmwvc_analysis.charts import chart_files, style
from pmwvc_analysis.figures.figures import FIGURES, charts, write_all
from pmwvc_analysis.figures.link_charts import energy, network
from pmwvc_analysis.figures.motion_charts import forces, positions
from pmwvc_analysis.traces.sums import runs


def lines(chart, row=0):
    """The lines of a panel by label."""
    return {line.label: line for line in chart.panels[row].lines}


@pytest.fixture(scope="module")
def live():
    """Traces of a session with an absent avatar and a late server."""
    traces = handmade.session()
    traces.server.state[0][:100] = 0
    return traces


def test_lines_of_motion_are_in_millimetres_and_an_absent_avatar_is_not_drawn(live):
    drawn = lines(positions(live, handmade.scenario()))
    assert list(drawn) == [
        "target", "object", "user1 device", "user2 device", "user1 avatar", "user2 avatar"
    ]  # fmt: skip
    np.testing.assert_allclose(drawn["user1 device"].y, live.users[0].x_m[:, 0] * 1e3, atol=1e-6)
    assert np.isnan(drawn["user1 avatar"].y[:100]).all()
    assert np.isfinite(drawn["user1 avatar"].y[100:]).all()


@pytest.mark.parametrize(("users", "dof"), [(2, 1), (2, 3), (2, 6), (6, 1)])
def test_every_axis_has_a_row_and_more_than_two_users_have_rows_of_their_own(users, dof):
    traces = handmade.session(users=users, dof=dof, duration_s=1.6)
    panels = positions(traces, None).panels
    axes = ["x [mm]", "y [mm]", "z [mm]", "about x [mm]", "about y [mm]", "about z [mm]"]
    owners = [f"user{n}" for n in range(1, 7)] if users > 2 else [""]
    names = ["position [mm]"] if dof == 1 else axes[:dof]
    assert [(p.title, p.y_label) for p in panels] == [(o, n) for o in owners for n in names]
    assert len({panel.tint for panel in panels}) == len(owners)
    assert len(forces(traces, None).panels) == users * dof


def test_the_servers_curves_end_with_the_users():
    traces = handmade.session()
    traces.duration_s = 3.0  # the masters end a second before the server
    for user in traces.users:
        kept = user.time_s <= 3.0
        for name in ("time_s", "tick", "x_m", "xd_m", "f_h", "f_m", "f_applied"):
            setattr(user, name, getattr(user, name)[kept])
    for draw in (positions, forces):
        for line in (line for panel in draw(traces, None).panels for line in panel.lines):
            assert line.x[-1] <= 3.0 + 1e-9


def test_energy_is_what_was_judged():
    traces = handmade.session()
    expected = user_energies(traces)[1].down.balance_j * 1e3
    np.testing.assert_allclose(lines(energy(traces, None), 1)["down, to the device"].y, expected)


@pytest.mark.parametrize(("gain", "marked"), [(1.0, False), (1.2, True)])
def test_a_violation_is_marked_and_named(gain, marked):
    panel = energy(handmade.session(gain=gain), None).panels[0]
    assert bool(panel.bands) is marked
    assert any("mJ more out than in" in band.label for band in panel.bands) is marked


def test_lost_packets_are_marked_and_counted():
    traces = handmade.session()
    fates = traces.fates["user1/up"]
    fates.fate[10:20], fates.time_out_ns[10:20] = 1, 0
    panel = next(p for p in network(traces, None).panels if p.title.startswith("user1 up"))
    assert panel.title == "user1 up: 500 packets, 10 lost"
    marks = {dots.label: dots for dots in panel.dots}
    assert len(marks["lost"].x) == 10
    assert len(marks["delivered"].x) == 488


def test_a_force_near_its_limit_shows_the_limit():
    traces, scenario = handmade.session(), handmade.scenario(safety__max_force=1.2)
    assert [level.y for level in forces(traces, scenario).panels[0].levels] == [1.2]
    assert not forces(traces, handmade.scenario()).panels[0].levels


def test_every_figure_is_written_with_its_points_units_and_source(live, tmp_path):
    event = {"time_s": 0.5, "who": "user1", "kind": "grip", "what": "<gripped> & held"}
    marked = dataclasses.replace(live, events=[event])
    drawn = charts(marked, handmade.scenario())
    write_all(drawn, marked, tmp_path)
    names = ["positions", "forces", "energy", "network"]
    assert [chart.name for chart in drawn] == names
    assert len(drawn) == len(FIGURES)
    for chart in drawn:
        head = (tmp_path / f"{chart.name}.png").read_bytes()[:24]
        assert head[:8] == b"\x89PNG\r\n\x1a\n"
        assert struct.unpack(">I", head[16:20])[0] == style.WIDTH_IN * style.DPI
        svg = tmp_path / f"{chart.name}.svg"
        assert ET.parse(svg).getroot().tag == "{http://www.w3.org/2000/svg}svg"
        assert chart.title in svg.read_text("utf-8")
        assert chart.caption and "press" in chart.title and "K = 500 N/m" in chart.note
        figure = chart_files.figure(chart, (0.0, live.duration_s))
        for axes, panel in zip(figure.axes, chart.panels, strict=True):
            assert "[" in panel.x_label and ("[" in panel.y_label or panel.y_label == "ticks")
            shown = {line.get_label(): line.get_ydata() for line in axes.lines}
            for line in panel.lines:
                np.testing.assert_array_equal(shown[line.label], line.y)
            marks = [text.get_text() for text in axes.texts if text.xy == (0.5, 1.0)]
            assert marks == ["1"] * panel.of_time


def test_what_was_not_recorded_is_left_out():
    def names(**without):
        traces = handmade.session()
        vars(traces).update(without)
        return [chart.name for chart in charts(traces, None)]

    assert names(server=None, fates={}) == ["positions", "forces"]
    assert names(server=None, fates={}, users=[]) == []
    assert names(users=[]) == ["positions", "network"]


def test_stretches_close_together_are_one():
    time_s = np.arange(10) * 0.1
    flags = np.array([0, 1, 1, 0, 1, 0, 0, 0, 0, 1], dtype=bool)
    found = runs(flags, time_s, join_s=0.25)
    assert found == [(1, 4), (9, 9)]
