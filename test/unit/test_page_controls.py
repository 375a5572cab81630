# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The parameters that a page may change: taken over by a running simulation, or refused."""

import asyncio
import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.plain import load

from pmwvc_core.errors import ParameterError
from pmwvc_core.params import LinkParams
from pmwvc_core.scenario.scenario import PARAMETERS
from pmwvc_view import controls
from pmwvc_view.description import predicted
from pmwvc_view.session import RATE, towards
from pmwvc_view.simulated import SimulatedSession

LIVE = load("live")
PERIOD_S = 0.016


class Running:
    """A simulated session of a page, polled as its server would, on a clock of its own."""

    def __init__(self, scenario=LIVE):
        self.now_s = 0.0
        clock = lambda: self.now_s  # noqa: E731
        self.session = SimulatedSession(scenario, clock=clock)

    def polls(self, count, targets=()):
        """Poll so many times, hands held; return the rows."""
        rows = []
        for _ in range(count):
            self.now_s += PERIOD_S
            for user, place in targets:
                self.session.target(user, place)
            rows += [each.row for each in self.session.poll()]
        return np.array(rows)

    def value(self, rows, name):
        return rows[:, self.session.layout.slices[name]][:, 0]

    def set(self, path, value):
        return asyncio.run(self.session.set(path, value))


def test_every_control_is_a_parameter_with_its_range():
    for each in controls.to_page(controls.values_of(LIVE)):
        if each["path"] not in (controls.PRESET, controls.CONTROLLER):
            leaf = each["path"].replace("link.", "link.up.")
            assert each["unit"] == PARAMETERS[leaf].spec.unit
        if each["slider"]:
            low, high = each["slider"]
            for value in (low, high):
                controls.changed(
                    LIVE, {each["path"]: value}
                )  # a slider never asks for the refused


@given(st.sampled_from(sorted(PARAMETERS)), st.integers(0, 9))
def test_no_other_parameter_can_be_reached_from_a_page(name, number):
    path = f"user{number}.{name}" if number else name
    allowed = {control.path for control in controls.CONTROLS}
    if name in allowed:
        return
    with pytest.raises(ParameterError, match="cannot be changed here"):
        controls.changed(LIVE, {path: "/etc/passwd"})


@given(st.floats(0.0, 0.3), st.floats(0.0, 0.3), st.floats(0.004, 0.1))
def test_delay_never_steps_by_more_than_its_rate_and_arrives(begin_s, end_s, over_s):
    present, wanted = LinkParams(delay_s=begin_s), LinkParams(delay_s=end_s, loss=0.1)
    for _ in range(int(abs(end_s - begin_s) / (RATE * over_s)) + 2):
        before, present = present, towards(present, wanted, over_s=over_s)
        assert abs(present.delay_s - before.delay_s) <= RATE * over_s * (1 + 1e-9)
    assert present == wanted


def test_dragging_the_delay_up_drops_no_hand_and_a_step_would():
    drag = [("user1", (-0.02,)), ("user2", (0.02,))]
    running = Running()
    running.polls(80, drag)
    assert running.set("link.delay_s", 0.09).done
    rows = running.polls(120, drag)
    assert set(running.value(rows, "user1.state")) == {1.0}
    assert running.value(rows, "user1.delay_up")[-1] == pytest.approx(0.09, abs=1e-3)
    simulation = running.session._simulation
    far = controls.changed(LIVE, {"link.delay_s": 0.3})
    simulation.change(far)  # the control: at once
    rows = running.polls(40, drag)
    assert 2.0 in set(running.value(rows, "user1.state"))


@settings(max_examples=4, deadline=None)
@given(
    st.sampled_from(["server.contact_stiffness", "server.contact_damping", "master.impedance"]),
    st.floats(0.0, 1.0),
    st.floats(0.0, 1.0),
)
def test_setting_changed_under_load_makes_no_energy_in_the_channel(path, first, second):
    low, high = controls.control_of(path).ends
    drag = [("user1", (-0.02,)), ("user2", (0.02,))]
    running = Running()
    running.polls(70, drag)
    for ratio in (first, second):
        value = max(low, 1.0) + ratio * (high - max(low, 1.0))
        assert running.set(path, value).done
        rows = running.polls(30, drag)
    for user, way in itertools.product(("user1", "user2"), ("up", "down")):
        least = running.value(rows, f"{user}.energy_{way}_min")[-1]
        moved = running.value(rows, f"{user}.energy_{way}_in")[-1]
        assert least >= -1e-6 - 1e-6 * moved


def test_where_no_model_tells_what_is_rendered_a_proposal_is_measured():
    scenario = load("wall")
    found = [predicted(scenario, {"controller": name}, False) for name in ("pspm", "pmwvc")]
    said = [[line for line in each["lines"] if line.startswith("Measured")] for each in found]
    (line,), none = said
    assert none == [] and found[0]["mass"] is None  # no number of the exact model
    assert "a swing of at most 0.5 N at 1.56 Hz: stiffness 333.3 N/m, in free space" in line


def test_restart_with_another_controller_begins_anew_with_the_same_hands():
    running = Running()
    running.polls(70)
    before = running.session.generation
    assert not running.set("controller", "direct").done
    assert running.session.restart({"controller": "direct"}).done
    assert running.session.generation == before + 1
    assert running.session.message({})["controller"] == "direct"
    rows = running.polls(70, [("user1", (-0.02,))])
    assert np.isnan(running.value(rows, "user1.energy_up_min")).all()
    assert not running.value(rows, "user2.held").any()  # known of a hand that nobody has closed
    assert running.value(rows, "user1.held")[-1] == 1.0


def test_paused_time_stands_still_and_goes_on_where_it_was():
    running = Running()
    running.polls(20)
    asyncio.run(running.session.pause(True))
    assert len(running.polls(50)) == 0
    asyncio.run(running.session.pause(False))
    rows = running.polls(2)
    assert running.value(rows, "time_s")[0] == pytest.approx(21 * PERIOD_S, abs=1.01 * PERIOD_S)


def test_hand_of_a_page_reaches_no_farther_than_its_workspace_and_force():
    running = Running()
    running.polls(70)
    rows = running.polls(150, [("user1", (1e9,)), ("user2", (-1e9,))])
    reach = LIVE.users[0].device.workspace_m
    limit = LIVE.users[0].safety.max_force
    assert np.abs(running.value(rows, "user1.x_m")).max() <= reach
    for name in ("user1.f_min", "user1.f_max", "user2.f_min", "user2.f_max"):
        assert np.abs(running.value(rows, name)).max() <= limit
