# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Predicted stiffness, mass and lead against the exact model and a simulated press, with ends of
equal and of different impedance.
"""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from support import plain as scenarios
from support.pressed_wall import wall

from pmwvc_analysis.models import linearize
from pmwvc_analysis.models.stability import radii
from pmwvc_analysis.prediction.lag import lag_s, rendered_mass, rendered_stiffness, transformer
from pmwvc_analysis.prediction.prediction import prediction
from pmwvc_analysis.prediction.text import lines
from pmwvc_analysis.transparency import frequency
from pmwvc_analysis.transparency.pressing import pressing
from pmwvc_analysis.transparency.transparency import transparency, untouched
from pmwvc_analysis.verdicts.verdicts import summary
from pmwvc_core.simulation.session import simulate_one

FILTERS = (
    {"kind": "integrate_and_dump"},
    {"kind": "none"},
    {"kind": "first_order", "pole_rad_s": 51.0},
    {"kind": "first_order", "cutoff_hz": 20.0},
    {"kind": "butterworth", "pass_hz": 20.0, "stop_hz": 60.0},
)


LOW_HZ = np.array([0.01, 0.02, 0.04, 0.08])


def at_rest(scenario, values, *, live):
    """The limit of a quantity formed of f/x at low frequencies, by the exact model."""
    found = frequency.response(linearize.build(scenario, live=live), LOW_HZ)
    return frequency.limit_at_rest(values(1.0 / found))


@settings(max_examples=8)
@given(
    impedance=st.floats(8.0, 80.0),
    server=st.floats(8.0, 80.0),
    stiffness=st.floats(50.0, 5000.0),
    mass=st.floats(0.1, 0.5),
    filtering=st.sampled_from(FILTERS),
    hold=st.sampled_from(["zoh", "foh"]),
    m=st.sampled_from([1, 2, 8, 20]),
    up=st.floats(0.0, 0.03),
    down=st.floats(0.0, 0.03),
    live=st.booleans(),
)
def test_stiffness_and_mass_are_those_of_the_exact_model(
    impedance, server, stiffness, mass, filtering, hold, m, up, down, live
):
    scenario = wall(
        **{
            "master.impedance": impedance,
            "server.impedance": server,
            "master.rate_drop": m,
            "server.period_s": m * 1e-3,
            "master.hold": hold,
            "device.mass": mass,
            "device.damping": 3.0,
            "server.contact_stiffness": stiffness,
            "link.up.delay_s": up,
            "link.down.delay_s": down,
            **{f"master.filter.{name}": value for name, value in filtering.items()},
        }
    )
    assume(radii(scenario, live=live)[0] < 1.0 - 1e-5)
    assume(radii(untouched(scenario), live=live)[0] < 1.0 - 1e-5)
    user = scenario.users[0]
    k_felt = at_rest(scenario, lambda ratio: ratio.real, live=live)
    tau = lag_s(user, scenario, live=live)
    assert rendered_stiffness(user, tau) == pytest.approx(k_felt, rel=1e-4)
    omega = 2.0 * np.pi * LOW_HZ
    m_felt = at_rest(untouched(scenario), lambda ratio: -ratio.real / omega**2, live=live)
    of_the_device = mass + 3.0 * 0.5e-3  # b_hd T_c/2: its force is held
    free = lag_s(user, scenario, live=live, touching=False)
    assert impedance * free / 2.0 + of_the_device == pytest.approx(m_felt, rel=1e-3, abs=1e-4)


@pytest.mark.parametrize("live", [False, True])
@pytest.mark.parametrize(("m", "steps"), [(8, 8), (4, 8), (8, 4), (1, 1)])
def test_stiffness_and_mass_of_the_strict_channel_are_those_of_the_exact_model(m, steps, live):
    """With nothing touched the lag is a tick less; the control is the tick, 2 % of the mass."""
    changes = {"master.rate_drop": m, "server.period_s": steps * 1e-3, "link.delay_s": 0.016}
    scenario = wall(channel="strict", **changes)
    user, found = scenario.users[0], transparency(scenario, np.ones(1), live=live).rendered
    in_touch = rendered_stiffness(user, lag_s(user, scenario, live=live))
    assert in_touch == pytest.approx(found.k_felt, rel=1e-5)
    mass = rendered_mass(user, scenario, live=live)
    link = found.mass_felt - user.device.mass
    assert mass == pytest.approx(link, rel=1e-4)
    assert mass + 25.0 * 0.5e-3 != pytest.approx(link, rel=1e-2)


@pytest.mark.parametrize("server", [25.0, 40.0, 12.0])
def test_a_steady_press_ends_where_it_is_expected(server):
    """x_m = n x_s + F tau/(2b): with different ends the device moves n times as far."""
    press = {"operator.force": 1.0, "server.impedance": server, "link.delay_s": 0.016}
    traces = simulate_one(wall(**press))
    scenario = wall(**press)
    user = scenario.users[0]
    n = math.sqrt(transformer(user))
    x_m = traces.users[0].x_m[-1, 0] - traces.users[0].x_m[0, 0]
    x_s = traces.server.x_s[0][-1, 0] + 0.5 * scenario.server.object_size_m  # from the wall's face
    force = traces.users[0].f_applied[-1, 0]
    lead = force * lag_s(user, scenario, live=False) / (2.0 * 25.0)
    assert x_m - n * x_s == pytest.approx(lead, abs=5e-6)
    assert traces.server.f_s[0][-1, 0] == pytest.approx(n * force, rel=1e-3)
    result = summary(traces, scenario)
    text = "\n".join(each["text"] for each in result["outcomes"])
    assert ("(hit; tolerance" in text) is (server == 25.0)
    assert ("offset of the device" in text) is (server == 25.0)
    assert ("the ends have different impedance" in "\n".join(lines(scenario, live=False))) is (
        server != 25.0
    )


def test_one_server_end_of_another_impedance_keeps_the_object_in_balance():
    """The other user presses as much harder as the transformer takes."""
    settings_texts = ["user1.server.impedance=40"]
    scenario = scenarios.load("carry_16ms", settings_texts=settings_texts)
    found = transparency(scenario)
    text = "\n".join(found.notes)
    assert "keeps moving" not in text
    assert pressing(scenario, 0)[:, 0] == pytest.approx([1.0, -math.sqrt(1.6)])
    assert pressing(scenario, 1)[:, 0] == pytest.approx([-math.sqrt(1.0 / 1.6), 1.0])
    assert found.rendered.k_felt is not None
    assert "1.26 times as far as its avatar" in "\n".join(lines(scenario, live=False))


def test_both_ends_are_in_the_prediction():
    """The control: without n^2 it would be 313 N/m."""
    texts = ["server.impedance=40", "master.filter.kind=first_order"]
    scenario = scenarios.load("carry_16ms", settings_texts=texts)
    assert prediction(scenario, live=False)["k_felt"] == pytest.approx(227.8, abs=0.1)
    assert transparency(scenario).rendered.k_felt == pytest.approx(227.8, abs=0.1)
