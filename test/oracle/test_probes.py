# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The measurements of probing sessions against the exact model and closed forms."""

import numpy as np
import pytest
from support.plain import load

from pmwvc_analysis.compare.probes import free_space, pressed_stiffness, probed, swing_hz
from pmwvc_analysis.models.linearize import build
from pmwvc_analysis.traces.felt import felt
from pmwvc_analysis.transparency.frequency import response
from pmwvc_analysis.transparency.transparency import transparency, untouched
from pmwvc_core.simulation.session import simulate_one
from pmwvc_core.traces import SessionTraces

SQUEEZED = (("carry_16ms", []), ("carry_16ms", ["controller=virtual_coupling"]))


@pytest.mark.parametrize(
    ("name", "settings"), [*SQUEEZED, ("wall", ["link.delay_s=0.05", "device.damping=2"])]
)
def test_mass_and_damping_in_free_space_are_those_of_the_exact_model(name, settings):
    scenario = load(name, settings_texts=settings)
    found = free_space(scenario)
    assert found.frequency_hz == pytest.approx(swing_hz(scenario), rel=1e-3)
    omega = 2.0 * np.pi * found.frequency_hz
    alone = load(name, settings_texts=settings, users=1)
    model = build(untouched(alone))
    impedance = 1.0 / response(model, np.array([found.frequency_hz]))[0]
    impedance *= np.exp(-0.5j * omega * scenario.tick_s)  # the force is held for a tick
    assert found.mass_kg == pytest.approx(-impedance.real / omega**2, rel=0.01)
    assert found.damping_n_s_m == pytest.approx(impedance.imag / omega, rel=0.02, abs=0.02)


@pytest.mark.parametrize(
    ("channel", "tau_s", "free_s"), [("strict", 0.0435, 0.0425), ("plain", 0.0435, 0.0435)]
)
def test_without_the_device_a_link_of_waves_is_b_tau_half_and_in_contact_tau_over_two_b(
    channel, tau_s, free_s
):
    """Closed forms against two simulated sessions and the exact model; the control is the device,
    of which nothing may be left in the numbers of the link.
    """
    settings = [f"channel={channel}", "master.impedance=30", "server.impedance=30"]
    settings += ["device.damping=2", "link.delay_s=0.016", "server.contact_stiffness=800"]
    for mass in (0.2, 0.4) if channel == "plain" else (0.3,):
        scenario = load("wall", settings_texts=[*settings, f"device.mass={mass}"])
        (found, how), exact = probed(scenario), transparency(scenario).rendered
        for each, near in ((found, 0.02), (exact, 1e-3)):  # a swing is not at rest
            assert each.mass_felt - mass == pytest.approx(30.0 * free_s / 2.0, rel=near)
            assert each.b_free - 2.0 == pytest.approx(0.0, abs=0.1)
            assert 1.0 / each.k_felt == pytest.approx(1.0 / 800.0 + tau_s / 60.0, rel=1e-3)
        assert how.startswith("stiffness by a press of 0.5 to 1 N, mass and damping by a swing of")


def test_each_user_is_probed_through_its_own_link():
    """Of the first one mass and compliance of the link would be half and twice as much."""
    settings = ["user2.master.impedance=50", "user2.server.impedance=50", "channel=plain"]
    scenario = load("carry_16ms", settings_texts=settings)
    (found, _), exact = probed(scenario, 1), transparency(scenario, user=1).rendered
    device = float(scenario.users[1].device.mass)
    assert found.mass_felt - device == pytest.approx(50.0 * 0.0435 / 2.0, rel=0.02)
    assert found.mass_felt - device == pytest.approx(exact.mass_felt - device, rel=0.02)
    assert 1.0 / found.k_felt == pytest.approx(1.0 / 500.0 + 0.0435 / 100.0, rel=1e-4)


@pytest.mark.parametrize(
    ("effects", "low", "high"),
    [
        (["channel=strict", "link.loss=0.1"], 325.0, 350.0),  # its playout waits for what is late
        (["channel=plain", "link.loss=0.1"], 335.0, 350.0),
        (["channel=zeroing", "link.loss=0.1"], None, None),  # the control: motion is lost
    ],
)
def test_what_loss_makes_of_a_stiffness_is_measured_and_a_device_that_creeps_has_none(
    effects, low, high
):
    """Without loss 357 (strict) and 348 N/m: what the model gives, which leaves loss out."""
    found = pressed_stiffness(load("carry_16ms", settings_texts=effects))
    assert found is None if low is None else low < found < high


def moved(channel, m, hold="zoh", b=10.0):
    """A hand that swings a device with nothing touched, at 1.5 Hz, and its acceleration, RMS."""
    settings = [
        "operator.kind=sinusoid", "operator.force=2", "operator.frequency_hz=1.5",
        "task.kind=free", "device.mass=1", "device.damping=8", "device.workspace_m=10",
        "link.delay_s=0.008", f"master.impedance={b}", f"server.impedance={b}",
        f"channel={channel}", f"server.period_s={m / 1000}", f"master.rate_drop={m}",
        f"master.hold={hold}",
    ]  # fmt: skip
    scenario = untouched(load("wall", settings_texts=settings, duration_s=6.0))
    user = simulate_one(scenario).users[0]
    late = user.time_s >= 2.0
    turns = np.exp(-2j * np.pi * 1.5 * user.time_s[late])
    amplitude = 2.0 * abs(user.xd_m[late, 0] @ turns) / late.sum()
    session = SessionTraces("simulated", 6.0, [user], None)
    return felt(session, user, scenario).buzz_n, 2.0 * np.pi * 1.5 * amplitude / np.sqrt(2.0)


@pytest.mark.parametrize(("m", "b"), [(8, 10.0), (8, 5.0)])
def test_a_moving_hand_feels_waves_that_are_held_as_buzz_of_b_a_t(m, b):
    """The wave held for T is a sawtooth of b a T about b xd: b a T sqrt((1 - 1/M^2)/12) rms."""
    buzz_n, a = moved("plain", m, b=b)
    assert buzz_n == pytest.approx(b * a * m / 1000 * np.sqrt((1.0 - 1.0 / m**2) / 12.0), rel=0.03)


@pytest.mark.parametrize("channel", ["plain", "strict"])
def test_a_wave_that_rises_evenly_does_not_buzz(channel):
    """Behind a hold of first order, and behind the ramp of the strict channel."""
    buzz_n, a = moved(channel, 8, "foh")
    assert buzz_n < 0.02 * 10.0 * a * 0.008 / np.sqrt(12.0)


def test_a_bare_device_has_its_own_mass_and_damping():
    settings = ["controller=direct", "device.damping=2", "device.mass=0.4"]
    found = free_space(load("carry_16ms", settings_texts=settings))
    assert found.mass_kg == pytest.approx(0.4, rel=1e-4)
    assert found.damping_n_s_m == pytest.approx(2.0, abs=1e-4)  # the hold alone: -0.009


@pytest.mark.parametrize(("name", "settings"), SQUEEZED)
def test_a_press_shows_the_stiffness_at_rest_of_the_exact_model(name, settings):
    scenario = load(name, settings_texts=settings)
    exact = transparency(scenario).rendered.k_felt
    assert pressed_stiffness(scenario) == pytest.approx(exact, rel=1e-3)


def test_two_springs_in_series_are_what_set_position_modulation_renders():
    words = ["controller=pspm", "baseline.pspm.stiffness=500", "server.contact_stiffness=1000"]
    found = pressed_stiffness(load("wall", settings_texts=words))
    assert found == pytest.approx(1000.0 / 3.0, rel=1e-3)


def test_what_diverges_creeps_or_is_not_held_has_no_stiffness():
    """The controls: direct coupling far away, a sampled wall that loses energy, a loose object."""
    far = load("wall", settings_texts=["controller=direct", "link.delay_s=0.05"])
    assert pressed_stiffness(far) is None
    alone = load("carry_16ms", users=1)
    assert pressed_stiffness(alone) is None
    assert free_space(load("active_wall")) is None


def test_a_loan_of_position_feedback_adds_no_mass_and_no_damping_in_free_space():
    lent = ("master.position.gain=20", "master.position.storage_j=0.02")
    settings = ["channel=strict", "link.loss=0.1"]
    without = free_space(load("carry_16ms", settings_texts=settings))
    found = free_space(load("carry_16ms", settings_texts=[*settings, *lent]))
    assert found.mass_kg == pytest.approx(without.mass_kg, rel=0.01)
    assert found.damping_n_s_m == pytest.approx(without.damping_n_s_m, abs=0.02)
