# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Figures: what they show, and that they stand for themselves."""

import struct

import numpy as np
import pytest
from support import handmade

from pmwvc_analysis.budget.budget import budget
from pmwvc_analysis.budget.energy import user_energies
from pmwvc_analysis.budget.parts import account_words, group_of, words_of
from pmwvc_analysis.charts import chart_files, style
from pmwvc_analysis.figures.energy_charts import accounts, whereabouts
from pmwvc_analysis.figures.figures import FIGURES, charts, write_all
from pmwvc_analysis.figures.link_charts import energy, loop, network
from pmwvc_analysis.figures.motion_charts import forces, positions
from pmwvc_analysis.traces.sums import runs
from pmwvc_core.simulation.session import simulate_one


def lines(chart, row=0):
    """The lines of a panel by label."""
    return {line.label: line for line in chart.panels[row].lines}


def grouped(found):
    """The energies of a budget by group, over all owners."""
    sums = {}
    for parts in found.parts.values():
        for part, series in parts.items():
            name = group_of(part)
            sums[name] = sums.get(name, 0.0) + series
    return sums


def live():
    traces = handmade.session()
    for place, user in enumerate(traces.users):
        user.lateness_s = np.random.default_rng(place).gamma(2.0, 40e-6, len(user.tick))
        user.accounts["position_spent"] = np.linspace(0.0, 2e-3, len(user.block_time_s))
    return traces


def test_positions_are_in_millimetres_with_one_line_each():
    traces = handmade.session()
    drawn = lines(positions(traces, handmade.scenario()))
    assert list(drawn) == [
        "target", "object", "user1 device", "user2 device", "user1 avatar", "user2 avatar"
    ]  # fmt: skip
    np.testing.assert_allclose(drawn["user1 device"].y, traces.users[0].x_m[:, 0] * 1e3)


def test_six_axes_have_a_row_and_a_name_each():
    chart = positions(handmade.session(dof=6), handmade.scenario(dof=6))
    names = [panel.y_label for panel in chart.panels]
    assert names[:4] == ["x [mm]", "y [mm]", "z [mm]", "axis 4 [mm]"]
    assert len(names) == 6


def test_an_avatar_that_is_absent_is_not_drawn():
    traces = handmade.session()
    traces.server.state[0][:100] = 0
    drawn = lines(positions(traces, None))["user1 avatar"].y
    assert np.isnan(drawn[:100]).all()
    assert np.isfinite(drawn[100:]).all()


def test_every_axis_of_motion_has_a_row():
    chart = positions(handmade.session(dof=3), handmade.scenario(dof=3))
    assert [panel.y_label for panel in chart.panels] == ["x [mm]", "y [mm]", "z [mm]"]
    forces_of = forces(handmade.session(dof=3), None)
    assert [panel.y_label for panel in forces_of.panels[:3]] == [
        "force, x [N]", "force, y [N]", "force, z [N]"
    ]  # fmt: skip


def test_energy_is_what_was_judged():
    traces = handmade.session()
    expected = user_energies(traces)[1].down.balance_j * 1e3
    np.testing.assert_allclose(lines(energy(traces, None), 1)["down, to the device"].y, expected)


@pytest.mark.parametrize(("gain", "marked"), [(1.0, False), (1.2, True)])
def test_a_violation_is_marked_and_named(gain, marked):
    panel = energy(handmade.session(gain=gain), None).panels[0]
    assert bool(panel.bands) is marked
    assert any("mJ" in note.text for note in panel.notes) is marked
    assert "more out than in" in "".join(band.label for band in panel.bands) or not marked


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


def test_virtual_time_has_no_lateness_to_draw():
    assert loop(handmade.session(), None) is None
    assert "median" in "".join(lines(loop(live(), None), 1))


def test_every_figure_is_written_and_states_where_it_comes_from(tmp_path):
    scenario, traces = handmade.scenario(), live()
    drawn = charts(traces, scenario)
    write_all(drawn, traces, tmp_path)
    names = ["positions", "forces", "energy", "budget", "controller", "network", "loop"]
    assert [chart.name for chart in drawn] == names
    assert len(drawn) == len(FIGURES)
    for chart in drawn:
        head = (tmp_path / f"{chart.name}.png").read_bytes()[:24]
        assert head[:8] == b"\x89PNG\r\n\x1a\n"
        assert struct.unpack(">I", head[16:20])[0] == style.WIDTH_IN * style.DPI
        assert chart.title in (tmp_path / f"{chart.name}.svg").read_text("utf-8")
        assert chart.caption


def test_axes_have_units_and_titles_name_the_scenario():
    for chart in charts(live(), handmade.scenario()):
        assert "press" in chart.title
        assert "K = 500 N/m" in chart.note
        for panel in chart.panels:
            assert "[" in panel.y_label or panel.y_label == "ticks"
            assert "[" in panel.x_label


def test_what_was_not_recorded_is_left_out():
    traces = handmade.session()
    traces.server, traces.fates = None, {}
    assert [chart.name for chart in charts(traces, None)] == ["positions", "forces"]
    traces.users = []
    assert charts(traces, None) == []


def test_a_server_alone_is_drawn():
    traces = handmade.session()
    traces.users = []
    assert [chart.name for chart in charts(traces, None)] == ["positions", "network"]


def test_png_and_description_show_the_same_points():
    traces = handmade.session()
    chart = energy(traces, None)
    figure = chart_files.figure(chart, (0.0, traces.duration_s))
    for axes, panel in zip(figure.axes, chart.panels, strict=True):
        drawn = {line.get_label(): line for line in axes.lines}
        for line in panel.lines:
            seen = drawn[line.label].get_ydata()
            assert np.nanmax(seen) == line.y.max()
            assert np.nanmin(seen) == line.y.min()


def test_stretches_close_together_are_one():
    time_s = np.arange(10) * 0.1
    flags = np.array([0, 1, 1, 0, 1, 0, 0, 0, 0, 1], dtype=bool)
    found = runs(flags, time_s, join_s=0.25)
    assert found == [(1, 4), (9, 9)]


def test_the_stack_of_energies_ends_where_the_hands_do():
    scenario = handmade.scenario()
    traces = simulate_one(scenario)
    panel = whereabouts(traces, scenario).panels[0]
    found = budget(traces, scenario)
    given = sum(found.hands.values()) * 1e3
    np.testing.assert_allclose(panel.lines[0].y, given)
    top = sum(np.maximum(sums, 0.0) for sums in grouped(found).values())
    bottom = sum(np.minimum(sums, 0.0) for sums in grouped(found).values())
    highest = max(layer.high.max() for layer in panel.layers)
    lowest = min(layer.low.min() for layer in panel.layers)
    assert highest == pytest.approx(top.max() * 1e3, rel=1e-2)
    assert lowest == pytest.approx(min(0.0, bottom.min() * 1e3), rel=1e-2, abs=1e-3)


def test_components_that_generated_energy_have_a_panel_of_their_own():
    quiet, wild = handmade.scenario(), handmade.scenario(server__coupling="one_step_delay")
    assert len(whereabouts(simulate_one(quiet), quiet).panels) == 1
    active = whereabouts(simulate_one(wild), wild).panels[1]
    assert active.title == "Components that generated energy"
    assert active.lines[0].label == f"server: {words_of('late_decoding')}"
    assert active.lines[0].y.min() < 0.0


def test_the_accounts_of_a_controller_are_drawn_only_where_it_has_some():
    traces = handmade.session()
    assert accounts(traces, None) is None
    user = traces.users[1]
    user.accounts["position_spent"] = np.linspace(0.0, 2e-3, len(user.block_time_s))
    chart = accounts(traces, None)
    assert [panel.title for panel in chart.panels] == ["user2"]
    drawn = lines(chart)[account_words("position_spent")]
    np.testing.assert_allclose(drawn.y, user.accounts["position_spent"] * 1e3)
