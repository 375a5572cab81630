# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Transmitted admittance of App. A Fig. 4 and App. E against the known numbers.

Those of Fig. 4 are of a packet that carries the filter's output of the very tick at which its
answer is applied; ours carries that of the tick before: a lag of one tick more, b/(2 T_c) in
series. That the model is the loop as it runs: ``test_multirate_model.py``.
"""

import numpy as np
import pytest

from pmwvc_analysis.transparency.transparency import transparency
from pmwvc_core.scenario.reader import parse_scenario

TICK_S, M = 1e-3, 20


def printed(*, impedance, mass=0.15, damping=1.0, stiffness=3500.0, contact_damping=25.0):
    return parse_scenario(
        {
            "name": "printed",
            "duration_s": 5.0,
            "controller": "pmwvc",
            "channel": "plain",
            "users": 1,
            "master": {
                "impedance": impedance,
                "rate_drop": M,
                "hold": "zoh",
                "filter": {"kind": "butterworth", "pass_hz": 25.0, "stop_hz": 50.0},
            },
            "device": {"mass": mass, "damping": damping},
            "operator": {"kind": "chirp"},
            "server": {
                "environment": "wall",
                "contact": "bilateral",
                "coupling": "unwrapped",
                "integrator": "trapezoid",
                "period_s": M * TICK_S,
                "contact_stiffness": stiffness,
                "contact_damping": contact_damping,
            },
            "task": {"kind": "free"},
        }
    )


@pytest.mark.parametrize(
    ("impedance", "stiffness", "peak_hz"), [(25.0, 939.4, 7.47), (80.0, 1889.2, 5.97)]
)
def test_fig_4_of_appendix_a(impedance, stiffness, peak_hz):
    felt = transparency(printed(impedance=impedance), np.array([1.0])).rendered
    assert 1 / felt.k_felt - TICK_S / (2 * impedance) == pytest.approx(1 / stiffness, rel=5e-4)
    assert felt.first_peak_hz == pytest.approx(peak_hz, rel=0.015)
    assert felt.first_peak_hz < peak_hz


def test_the_ideal_of_appendix_a():
    ideal = transparency(printed(impedance=25.0), np.array([1.0])).ideal
    assert ideal.k_felt == pytest.approx(3500.0, rel=1e-4)
    assert ideal.first_peak_hz == pytest.approx(15.87, abs=0.02)


def test_the_wall_of_appendix_e():
    scenario = printed(impedance=25.0, mass=0.1, damping=1.5, stiffness=500.0, contact_damping=1.0)
    found = transparency(scenario, np.array([1.0]))
    assert found.ideal.first_peak_hz == pytest.approx(11.0, abs=0.05)
    assert found.ideal.k_felt == pytest.approx(500.0, rel=1e-4)
    assert found.rendered.k_felt == pytest.approx(357.0, rel=2e-3)
