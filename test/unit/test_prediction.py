# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The predictions for a scenario."""

import pytest
from support import handmade
from support import plain as scenarios

from pmwvc_analysis.prediction.prediction import (
    aliasing_gain,
    answer,
    one_step_bound,
    passive,
    prediction,
)
from pmwvc_analysis.prediction.text import lines
from pmwvc_analysis.verdicts.outcomes import outcomes
from pmwvc_analysis.verdicts.verdicts import summary


def controlled(**overrides):
    """The controlled experiment of App. B: pole 50 rad/s, first-order hold, T_n = 8 ms."""
    values = {"master__filter__kind": "first_order", "master__filter__pole_rad_s": 50.0}
    return handmade.scenario(**values | {"master__hold": "foh"} | overrides)


LATE = {
    "server__coupling": "one_step_delay",
    "server__integrator": "backward_euler",
    "server__contact_damping": 10.0,
}


@pytest.mark.parametrize(("stiffness", "met"), [(625.0, True), (625.01, False)])
def test_one_step_delay_has_a_bound(stiffness, met):
    scenario = handmade.scenario(server__contact_stiffness=stiffness, **LATE)
    assert one_step_bound(scenario.users[0], scenario) is met


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
    assert passive(scenario) is proved


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


def test_words_summary_and_promise_are_one_answer():
    """What is not linear is not promised where its linear relative is unstable."""
    texts = (
        "device.friction=0.001 master.rate_drop=2 server.period_s=0.002 master.hold=zoh "
        "master.impedance=30 device.mass=0.18 device.damping=0.2 server.contact_stiffness=240 "
        "server.contact_damping=0 link.delay_s=0 server.contact=bilateral server.gap_m=0"
    )
    scenario = scenarios.load("wall", settings_texts=texts.split())
    text = "\n".join(lines(scenario, live=False))
    assert "NOT stable" in text and "Not proved stable at any constant delay" in text
    values = prediction(scenario, live=False)
    assert values["stable"] is None and values["any_delay"] is False
    assert answer(scenario, live=False).stable is None


def test_a_matrix_impedance_is_proved_by_its_eigenvalues():
    filtering = "master.filter.kind=first_order"
    light = scenarios.load("cube_3d", settings_texts=[filtering, "device.mass=0.005"])
    values = prediction(scenarios.load("cube_3d", settings_texts=[filtering]), live=False)
    assert values["spectral_radius"] < 1.0
    assert values["any_delay"] and values["stable"] is True
    found = prediction(light, live=False)
    assert not found["any_delay"] and found["stable"] is False


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        (
            "link.loss=0.02",
            "Not modelled: loss of 0.02 of the packets (user1 up, user1 down, user2",
        ),
        ("user2.link.up.duplicate=0.1", "duplication of 0.1 of the packets (user2 up)."),
        ("link.up.rate_limit_bps=1e6", "rate limit of 1e+06 bit/s (user1 up, user2 up)."),
    ],
)
def test_effects_of_the_link_that_no_prediction_has_are_named(setting, words):
    scenario = scenarios.load("carry_16ms", settings_texts=[setting])
    assert words in "\n".join(lines(scenario, live=True))
    assert len(prediction(scenario, live=True)["left_out"]) == 1
    assert prediction(scenarios.load("carry_16ms"), live=True)["left_out"] == []


def test_jitter_is_named_with_its_size():
    settings = ["link.jitter=normal", "link.jitter_s=0.005"]
    scenario = scenarios.load("carry_16ms", settings_texts=settings)
    assert "Not modelled: jitter (normal, 5 ms)" in "\n".join(lines(scenario, live=True))


@pytest.mark.parametrize(("mass", "stable"), [(0.0126, True), (0.0124, False)])
def test_a_device_too_light_for_its_damping_is_not_stable(mass, stable):
    scenario = handmade.scenario(device__mass=mass, server__contact_stiffness=0.0)
    assert prediction(scenario, live=False)["stable"] is stable
    assert passive(scenario) is stable


def test_the_example_of_app_b_ends_where_the_exact_model_gives():
    scenario = controlled(
        master__hold="zoh",
        server__coupling="one_frame_late",
        server__contact_damping=10.0,
        link__delay_s=0.016,
        server__contact_stiffness=2000.0,
    )
    values = prediction(scenario, live=False)
    assert values["k_max"] == pytest.approx(2166.0, rel=5e-3)
    assert values["stable"] is True and 0.9 < values["spectral_radius"] < 1.0
    assert prediction(scenario, live=True)["k_max"] != pytest.approx(values["k_max"], rel=0.02)


def test_no_largest_stiffness_is_none():
    scenario = controlled(link__delay_s=0.4)
    assert prediction(scenario, live=False)["k_max"] is None
    assert any("up to 1,000,000 N/m" in line for line in lines(scenario, live=False))


def test_direct_coupling_has_a_model_but_no_waves():
    scenario = handmade.scenario(controller="direct", server__contact_stiffness=40.0)
    values = prediction(scenario, live=False)
    assert values["k_max"] == pytest.approx(47.1, rel=5e-3)
    assert values["stable"] is True
    assert prediction(scenario, live=True)["stable"] is False
    assert values["k_felt"] is values["aliasing_gain"] is None


def test_what_is_not_linear_is_promised_only_what_is_proved():
    rubbing = {"device__friction": 0.1}
    values = prediction(handmade.scenario(**rubbing), live=False)
    assert values["spectral_radius"] is values["k_max"] is None
    assert values["stable"] is None
    late = prediction(handmade.scenario(server__coupling="one_frame_late", **rubbing), live=False)
    assert late["stable"] is None


def test_a_nonlinear_element_is_named_with_the_linear_relative():
    rubbing = handmade.scenario(device__friction=0.1, user2__device__encoder_step_m=1e-5)
    smooth = prediction(handmade.scenario(), live=False)
    said = lines(rubbing, live=False)
    assert "user1.device.friction = 0.1 N" in said[0]
    assert "user2.device.encoder_step_m = 1e-05 m" in said[0]
    assert "device.friction=0, device.encoder_step_m=0" in said[1]
    assert f"Stable: spectral radius {smooth['spectral_radius']:.5g}" in said[1]
    assert "relative" not in " ".join(lines(handmade.scenario(), live=False))


@pytest.mark.parametrize(
    ("predicted", "was", "words"),
    [
        (True, False, "but it was not"),
        (False, False, "unstable: it was"),
        (False, True, "but it was stable"),
        (None, True, "No stability was predicted; the session was stable"),
    ],
)
def test_the_outcome_of_a_prediction_is_stated(predicted, was, words):
    scenario = handmade.scenario()
    result = summary(handmade.session(), scenario)
    result["prediction"]["stable"], result["stable"] = predicted, was
    assert words in outcomes(scenario, result)[0].text


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


def test_a_filter_above_half_the_packet_rate_is_warned_of_with_its_gain():
    filtering = ["user2.master.filter.kind=first_order", "user2.master.filter.cutoff_hz=80"]
    scenario = scenarios.load("carry_16ms", settings_texts=filtering)
    (text,) = [line for line in lines(scenario, live=True) if "Warning" in line]
    gain = aliasing_gain(scenario.users[1])
    assert text.startswith("Warning: user2: the edge of the anti-aliasing filter (80 Hz (-3 dB))")
    assert "half the packet rate (62.5 Hz)" in text
    assert f"packets carry {gain:.4g} times the energy" in text
    assert gain > 1.5


def test_a_weak_filter_below_half_the_packet_rate_is_warned_of_too():
    filtering = ["master.filter.kind=first_order", "master.filter.cutoff_hz=50"]
    scenario = scenarios.load("carry_16ms", settings_texts=filtering)
    (text,) = [line for line in lines(scenario, live=True) if "Warning" in line]
    assert text.startswith("Warning: user1, user2: the anti-aliasing filter is weak")


@pytest.mark.parametrize(
    "setting",
    [
        {"master__bank__kind": "dissertation"},
        {"master__position__gain": 20.0, "master__position__feedback": "printed"},
    ],
)
def test_parts_that_generate_energy_are_not_called_passive_nor_rendered_by_their_lag(setting):
    plain, other = controlled(), controlled(**setting)
    assert passive(plain)
    assert not passive(other)
    assert not any("Stable at any constant delay" in line for line in lines(other, live=False))
    values = prediction(other, live=False)
    assert values["k_felt"] is values["mass_felt"] is None
    assert values["aliasing_gain"] is not None


@pytest.mark.parametrize(
    ("second", "ticks", "is_known"), [(97, 8 * 97, True), (101, 8 * 97 * 101, False)]
)
def test_a_pattern_that_repeats_too_late_is_named_with_its_length(second, ticks, is_known):
    scenario = handmade.scenario(
        user1__master__rate_drop=97, user2__master__rate_drop=second, users=2
    )
    text = "\n".join(lines(scenario, live=False))
    named = f"not known: a hyperperiod of {ticks} ticks: too much work" in text
    assert named is not is_known
