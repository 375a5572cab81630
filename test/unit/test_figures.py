# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Figures: what they show, and that they stand for themselves."""

import struct

import handmade
import numpy as np
import pytest

from pmwvc_analysis.judge.budget import budget
from pmwvc_analysis.judge.budget_words import GROUPS
from pmwvc_analysis.judge.energy import user_energies
from pmwvc_analysis.show import style
from pmwvc_analysis.show.channel_figures import energy, loop, network
from pmwvc_analysis.show.energy_figures import bookings, whereabouts
from pmwvc_analysis.show.figures import FIGURES, draw_all, forces, motion
from pmwvc_core.simulation.session import simulate_one


def lines(figure, row=0):
    """The labelled lines of a row of axes."""
    return lines_of(figure.axes[row])


def lines_of(axes):
    return {line.get_label(): line for line in axes.lines if not line.get_label().startswith("_")}


def grouped(found):
    """The energies of a budget by group, over all owners."""
    sums = {}
    for parts in found.parts.values():
        for part, series in parts.items():
            name = next(name for name, members in GROUPS.items() if part in members)
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
    drawn = lines(motion(traces, handmade.scenario()))
    assert list(drawn) == [
        "target", "object", "user1 device", "user2 device", "user1 avatar", "user2 avatar"
    ]  # fmt: skip
    np.testing.assert_allclose(drawn["user1 device"].get_ydata(), traces.users[0].x_m[:, 0] * 1e3)


def test_six_axes_have_a_row_and_a_name_each():
    figure = motion(handmade.session(dof=6), handmade.scenario(dof=6))
    names = [axes.get_ylabel() for axes in figure.axes]
    assert names[:4] == ["x [mm]", "y [mm]", "z [mm]", "axis 4 [mm]"]
    assert len(names) == 6


def test_an_avatar_that_is_absent_is_not_drawn():
    traces = handmade.session()
    traces.server.state[0][:100] = 0
    drawn = lines(motion(traces, None))["user1 avatar"].get_ydata()
    assert np.isnan(drawn[:100]).all()
    assert np.isfinite(drawn[100:]).all()


def test_every_axis_of_motion_has_a_row():
    figure = motion(handmade.session(dof=3), handmade.scenario(dof=3))
    assert [axes.get_ylabel() for axes in figure.axes] == ["x [mm]", "y [mm]", "z [mm]"]


def test_energy_is_what_was_judged():
    traces = handmade.session()
    figure = energy(traces, None)
    expected = user_energies(traces)[1].down.balance_j * 1e3
    np.testing.assert_allclose(lines(figure, 1)["down, to the hand"].get_ydata(), expected)


@pytest.mark.parametrize(("gain", "marked"), [(1.0, False), (1.2, True)])
def test_a_violation_is_hatched_and_named(gain, marked):
    axes = energy(handmade.session(gain=gain), None).axes[0]
    assert bool(axes.patches) is marked
    assert any("mJ" in text.get_text() for text in axes.texts) is marked


def test_lost_packets_are_marked_and_counted():
    traces = handmade.session()
    fates = traces.fates["user1/up"]
    fates.fate[10:20], fates.time_out_ns[10:20] = 1, 0
    figure = network(traces, None)
    axes = next(a for a in figure.axes if "user1" in a.get_title() and "up" in a.get_title())
    assert axes.get_title() == "user1, way up: 500 packets, 10 lost"
    marks = {line.get_label(): line for line in axes.lines}
    assert len(marks["lost"].get_xdata()) == 10
    assert len(marks["delivered"].get_xdata()) == 488


def test_a_force_near_its_limit_shows_the_limit():
    traces, scenario = handmade.session(), handmade.scenario(safety__max_force=1.2)
    assert "limit" in lines(forces(traces, scenario))
    assert "limit" not in lines(forces(traces, handmade.scenario()))


def test_virtual_time_has_no_lateness_to_draw():
    assert loop(handmade.session(), None) is None
    assert "median" in "".join(lines(loop(live(), None), 1))


def test_every_figure_is_written_and_says_where_it_comes_from(tmp_path):
    scenario = handmade.scenario()
    pictures = draw_all(live(), scenario, tmp_path)
    assert [picture.name for picture in pictures] == list(FIGURES)
    for picture in pictures:
        head = picture.path.read_bytes()[:24]
        assert head[:8] == b"\x89PNG\r\n\x1a\n"
        assert struct.unpack(">I", head[16:20])[0] == style.WIDTH_IN * style.DPI
        assert picture.caption


@pytest.mark.parametrize("draw", [entry[0] for entry in FIGURES.values()])
def test_axes_have_units_and_titles_name_the_scenario(draw):
    figure = draw(live(), handmade.scenario())
    assert "press" in figure.get_suptitle()
    assert "K = 500 N/m" in figure.get_supxlabel()
    for axes in figure.axes:
        assert "[" in axes.get_ylabel() or axes.get_ylabel() == "ticks"
    assert "[" in figure.axes[-1].get_xlabel()


def test_what_was_not_recorded_is_left_out(tmp_path):
    traces = handmade.session()
    traces.server, traces.fates = None, {}
    names = [picture.name for picture in draw_all(traces, None, tmp_path)]
    assert names == ["positions", "forces"]
    traces.users = []
    assert draw_all(traces, None, tmp_path) == []


def test_a_server_alone_is_drawn(tmp_path):
    traces = handmade.session()
    traces.users = []
    assert [p.name for p in draw_all(traces, None, tmp_path)] == ["positions", "network"]


def test_stretches_close_together_are_one():
    time_s = np.arange(10) * 0.1
    flags = np.array([0, 1, 1, 0, 1, 0, 0, 0, 0, 1], dtype=bool)
    spans = style.spans(flags, time_s, join_s=0.25)
    np.testing.assert_allclose(spans, [(0.1, 0.4), (0.9, 0.9)])


def test_users_can_be_told_apart_without_colour():
    assert len(set(style.USERS)) == 8


def test_the_stack_of_energies_ends_where_the_hands_do():
    scenario = handmade.scenario()
    traces = simulate_one(scenario)
    axes = whereabouts(traces, scenario).axes[0]
    found = budget(traces, scenario)
    given = sum(found.hands.values()) * 1e3
    np.testing.assert_allclose(lines_of(axes)["hands"].get_ydata(), given)
    top = sum(np.maximum(sums, 0.0) for sums in grouped(found).values())
    bottom = sum(np.minimum(sums, 0.0) for sums in grouped(found).values())
    edges = np.concatenate([area.get_paths()[0].vertices for area in axes.collections])
    assert edges[:, 1].max() == pytest.approx(top.max() * 1e3, rel=1e-2)
    assert edges[:, 1].min() == pytest.approx(min(0.0, bottom.min() * 1e3), rel=1e-2, abs=1e-3)


def test_parts_that_were_active_have_a_row_of_their_own():
    quiet, wild = handmade.scenario(), handmade.scenario(server__coupling="one_step_delay")
    assert len(whereabouts(simulate_one(quiet), quiet).axes) == 1
    active = whereabouts(simulate_one(wild), wild).axes[1]
    label, line = next(iter(lines_of(active).items()))
    assert label.split() == "server: decoding with the force of the step before".split()
    assert line.get_ydata().min() < 0.0


def test_what_a_controller_booked_is_drawn_only_where_it_did():
    traces = handmade.session()
    assert bookings(traces, None) is None
    user = traces.users[1]
    user.accounts["position_spent"] = np.linspace(0.0, 2e-3, len(user.block_time_s))
    figure = bookings(traces, None)
    assert [axes.get_title() for axes in figure.axes] == ["user2"]
    drawn = lines(figure)["given out by the position feedback"]
    np.testing.assert_allclose(drawn.get_ydata(), user.accounts["position_spent"] * 1e3)
