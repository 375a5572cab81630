# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The predictions for a scenario; the lag of a link, from filters, holds, phases and couplings."""

import re

import pytest
from support import handmade
from support import plain as scenarios

from pmwvc_analysis.models.any_delay import any_delay
from pmwvc_analysis.prediction.lag import lag_s, step_lag_s
from pmwvc_analysis.prediction.prediction import prediction
from pmwvc_analysis.prediction.text import lines, link_words
from pmwvc_analysis.transparency.transparency import transparency
from pmwvc_core.params import DeviceParams, FilterParams, MasterParams


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


def test_recorded_delays_lag_by_their_mean_over_time(tmp_path):
    """One second of 10 ms and three of 20 ms; the control is the mean as jitter round it."""
    path = tmp_path / "delays.txt"
    path.write_text("".join(f"{n / 10} {10 if n < 10 else 20}\n" for n in range(40)))
    settings = {"link__trace_file": str(path), "link__trace_scale": 0.001}
    recorded = handmade.scenario(link__delay_s=0.0, link__jitter="trace", **settings)
    spread = handmade.scenario(link__delay_s=0.0175, link__jitter="uniform", link__jitter_s=0.001)
    found, wanted = (lag_s(one.users[0], one, live=False) for one in (recorded, spread))
    assert found == pytest.approx(wanted)


@pytest.mark.parametrize("channel", ["plain", "strict"])
@pytest.mark.parametrize(("delay_s", "stiffness"), [(0.0, 1500.0), (0.02, 800.0)])
def test_an_avatar_that_leads_renders_as_in_the_exact_model(channel, delay_s, stiffness):
    """Once by more than the waves lag; nothing touched it leads by nothing."""
    scenario = scenarios.load(
        "wall",
        settings_texts=[
            f"channel={channel}",
            "server.coupling=one_step_delay",
            f"server.contact_stiffness={stiffness}",
            "server.contact_damping=1",
            f"link.delay_s={delay_s}",
            "master.filter.kind=none" if delay_s == 0.0 else "master.filter.kind=first_order",
        ],
    )
    (user,) = scenario.users
    found, exactly = prediction(scenario, live=False), transparency(scenario).rendered
    assert found["k_felt"] == pytest.approx(exactly.k_felt, rel=1e-4)
    assert found["mass_felt"] + user.device.mass == pytest.approx(exactly.mass_felt, abs=0.02)
    words = link_words(user, scenario, live=False)
    assert not re.search(r"-\d", words)
    leads = lag_s(user, scenario, live=False) < 0.0
    assert leads is (delay_s == 0.0)
    assert ("behind its avatar" in words) is leads


def test_steps_of_a_zero_order_hold_behind_a_pole_lag_by_their_end():
    """Nothing behind the mean of a frame, less than half a frame without a filter."""

    def behind(m, **filtering):
        master = MasterParams(rate_drop=m, hold="zoh", filter=FilterParams(**filtering))
        return step_lag_s(master, DeviceParams(mass=0.2, damping=2.0), 25.0) * 1e3

    assert behind(8, kind="integrate_and_dump") == pytest.approx(0.0, abs=1e-9)
    assert 2.0 < behind(8, kind="none") < 3.5
    assert behind(20, kind="first_order", pole_rad_s=51.0) == pytest.approx(1.3788, abs=1e-4)


@pytest.mark.parametrize(
    ("filtering", "felt", "mass"),
    [
        ("kind=exact order=1 share=0.5 alpha=0.929", 789.035, 0.4799),
        ("kind=complementary order=2", 689.899, 0.8545),
        ("kind=exact order=2 share=0.7", 869.565, 0.5850),
    ],
)
def test_the_lag_of_a_velocity_filter_is_that_of_the_exact_model(filtering, felt, mass):
    texts = [f"master.velocity_filter.{text}" for text in filtering.split()]
    scenario = scenarios.load(
        "wall_filtered",
        settings_texts=[*texts, "device.velocity=exact", "device.encoder_step_m=0.0"],
    )
    found = prediction(scenario, live=False)
    exactly = transparency(scenario).rendered
    assert found["k_felt"] == pytest.approx(felt, abs=1e-2)
    assert found["k_felt"] == pytest.approx(exactly.k_felt, rel=1e-5)
    assert found["mass_felt"] == pytest.approx(mass, abs=1e-3)
    device = scenario.users[0].device.mass
    assert found["mass_felt"] + device == pytest.approx(exactly.mass_felt, abs=2e-3)
