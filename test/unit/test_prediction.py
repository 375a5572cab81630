# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The predictions for a scenario."""

import pytest
from support import handmade
from support import plain as scenarios

from pmwvc_analysis.models.any_delay import any_delay
from pmwvc_analysis.prediction.prediction import prediction
from pmwvc_analysis.prediction.text import lines


def controlled(**overrides):
    """The controlled experiment of App. B: pole 50 rad/s, first-order hold, T_n = 8 ms."""
    values = {"master__filter__kind": "first_order", "master__filter__pole_rad_s": 50.0}
    return handmade.scenario(**values | {"master__hold": "foh"} | overrides)


LATE = {
    "server__coupling": "one_step_delay",
    "server__integrator": "backward_euler",
    "server__contact_damping": 10.0,
}


@pytest.mark.parametrize(
    ("environment", "stiffness", "proved"),
    [("wall", 625.0, True), ("wall", 2000.0, False), ("cube", 600.0, False)],
)
def test_one_step_delay_is_promised_at_a_wall_and_not_at_a_cube_under_held_forces(
    environment, stiffness, proved
):
    scenario = handmade.scenario(
        server__environment=environment, server__contact_stiffness=stiffness, **LATE
    )
    text = "\n".join(lines(scenario, live=False))
    assert ("Stable at any constant delay, hands off, while all contacts touch" in text) is proved
    assert (
        "Not proved stable at any constant delay: the gain around the loop is up to" in text
    ) is not proved


BLACK_BOX = {
    "server__coupling": "unknown",
    "server__environment": "wall",
    "server__contact_damping": 10.0,
    "server__decoding": "late",
}


@pytest.mark.parametrize(
    ("compensation", "stiffness", "proved"),
    [
        ("none", 625.0, True),
        ("none", 2000.0, False),
        ("ledger", 1e5, True),
        ("printed", 100.0, False),
    ],
)
def test_what_a_port_promises_that_knows_nothing_of_its_environment(
    compensation, stiffness, proved
):
    scenario = handmade.scenario(
        server__compensation=compensation, server__contact_stiffness=stiffness, **BLACK_BOX
    )
    assert any_delay(scenario).proved is proved


def test_a_ledger_promises_stability_though_it_is_not_linear():
    scenario = handmade.scenario(server__compensation="ledger", **BLACK_BOX)
    values = prediction(scenario, live=False)
    assert values["stable"] is True
    assert values["spectral_radius"] is None
    allowed = handmade.scenario(
        server__compensation="ledger",
        server__allowance_w=0.5,
        server__allowance_j=0.2,
        **BLACK_BOX,
    )
    assert prediction(allowed, live=False)["stable"] is None


def test_aliasing_is_warned_of_where_hands_could_use_it():
    """A held wave excites next to nothing beyond half the packet rate, so without hands the loop
    is stable at any delay all the same.
    """
    scenario = handmade.scenario(master__filter__kind="none")
    values = prediction(scenario, live=False)
    assert values["aliasing_gain"] == pytest.approx(8.0)
    assert any("Warning" in line and "aliasing" in line for line in lines(scenario, live=False))
    assert values["any_delay"] and values["loop_gain"] <= 1.0 + 1e-9


@pytest.mark.parametrize(("mass", "stable"), [(0.0126, True), (0.0124, False)])
def test_a_device_too_light_for_its_damping_is_not_stable(mass, stable):
    scenario = handmade.scenario(device__mass=mass, server__contact_stiffness=0.0)
    assert prediction(scenario, live=False)["stable"] is stable
    assert any_delay(scenario).proved is stable


def test_settings_without_effect_on_the_strict_channel_are_named_and_what_gives_them_one():
    def warnings(*texts):
        scenario = scenarios.load("carry_16ms", settings_texts=texts)
        return [line for line in lines(scenario, live=False) if "Warning" in line]

    wanted = ["user2.master.filter.kind=first_order", "user2.master.filter.cutoff_hz=50"]
    (strict,) = warnings("channel=strict", *wanted, "master.hold=zoh")
    for words in (
        "user1, user2: without effect: ",
        "master.hold = zoh",
        "master.filter.kind = first_order",
        "master.filter.cutoff_hz = 50.0",
        "channel = plain has both",
    ):
        assert words in strict
    assert not warnings("channel=strict")
    (plain,) = warnings("channel=plain", *wanted, "master.hold=zoh")
    assert plain.startswith("Warning: user2: the anti-aliasing filter is weak")


@pytest.mark.parametrize(
    "setting",
    [
        {"master__bank__kind": "dissertation"},
        {"master__position__gain": 20.0, "master__position__feedback": "printed"},
    ],
)
def test_parts_that_generate_energy_are_not_called_passive_nor_rendered_by_their_lag(setting):
    plain, other = controlled(), controlled(**setting)
    assert any_delay(plain).proved
    assert not any_delay(other).proved
    assert not any("Stable at any constant delay" in line for line in lines(other, live=False))
    values = prediction(other, live=False)
    assert values["k_felt"] is values["mass_felt"] is None
    assert values["aliasing_gain"] is not None
