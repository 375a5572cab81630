# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The measurements of probing sessions against the exact model and closed forms."""

import numpy as np
import pytest
from support.plain import load

from pmwvc_analysis.compare.rendered import free_space, pressed_stiffness, swing_hz
from pmwvc_analysis.models.linearize import build
from pmwvc_analysis.transparency.frequency import response
from pmwvc_analysis.transparency.transparency import transparency, untouched

LINEAR = (
    ("wall", []),
    ("carry_16ms", []),
    ("carry_16ms", ["controller=virtual_coupling"]),
    ("wall", ["link.delay_s=0.05", "device.damping=2"]),
)


@pytest.mark.parametrize(("name", "settings"), LINEAR)
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


@pytest.mark.parametrize("damping", [0.0, 2.0])
def test_a_bare_device_has_its_own_mass_and_damping(damping):
    settings = ["controller=direct", f"device.damping={damping}", "device.mass=0.4"]
    found = free_space(load("carry_16ms", settings_texts=settings))
    assert found.mass_kg == pytest.approx(0.4, rel=1e-4)
    assert found.damping_n_s_m == pytest.approx(damping, abs=1e-4)  # the hold alone: -0.009


@pytest.mark.parametrize(("name", "settings"), LINEAR[:3])
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


@pytest.mark.parametrize("settings", [(), ("link.loss=0.1",)], ids=["constant link", "loss"])
def test_a_loan_of_position_feedback_adds_no_mass_and_no_damping_in_free_space(settings):
    lent = ("master.position.gain=20", "master.position.storage_j=0.02")
    settings = ["channel=strict", *settings]
    without = free_space(load("carry_16ms", settings_texts=settings))
    found = free_space(load("carry_16ms", settings_texts=[*settings, *lent]))
    assert found.mass_kg == pytest.approx(without.mass_kg, rel=0.01)
    assert found.damping_n_s_m == pytest.approx(without.damping_n_s_m, abs=0.02)


def test_a_loan_of_position_feedback_renders_the_wall_itself():
    lent = ("master.position.gain=20", "master.position.storage_j=0.02")
    wall = ("channel=strict", "link.delay_s=0.016", "server.contact_stiffness=1000")
    assert pressed_stiffness(load("wall", settings_texts=wall)) < 700.0
    found = pressed_stiffness(load("wall", settings_texts=[*wall, *lent]))
    assert found == pytest.approx(1000.0, rel=0.01)
