# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What the exact model says of the loop of App. E: device, bank with a local model, a slow wall of
500 N/m, position feedback. It equals the model written by hand (``property/test_linear_model.py``)
and the simulator (``test_multirate_model.py``).
"""

import numpy as np
import pytest

from pmwvc_analysis.models.stability import radii
from pmwvc_analysis.transparency.transparency import transparency
from pmwvc_core.scenario.reader import parse_scenario

# High-pass filter of the scenario wall_local_model: it reaches down to the first resonance.
LOW_REACHING = {
    "master.bank.high_pass_hz": 3.0,
    "master.bank.high_pass_db": 3.0,
    "master.bank.high_stop_hz": 0.3,
    "master.bank.high_stop_db": 20.0,
}


def scenario(damping=5.0, bank="dissertation", **more):
    """App. E with B_lm [N s/m]: K_lm = 500, b = 25, 50 Hz packets, the filters of Table 1."""
    base = {"name": "local", "duration_s": 1.0, "controller": "pmwvc", "channel": "plain"}
    parts = {
        "master": {
            "impedance": 25.0,
            "rate_drop": 20,
            "hold": "zoh",
            "filter": {"kind": "butterworth", "pass_hz": 25.0, "stop_hz": 50.0},
            "bank": {"kind": bank},
            "local_model": {"stiffness": 500.0, "damping": damping},
            "position": {"feedback": "printed", "gain": 20.0},
        },
        "device": {"mass": 0.1, "damping": 1.5, "workspace_m": 1e9},
        "operator": {"kind": "chirp"},
        "server": {
            "environment": "wall",
            "contact": "bilateral",
            "contact_stiffness": 500.0,
            "contact_damping": 1.0,
            "period_s": 0.02,
        },
        "task": {"kind": "free"},
    }
    return parse_scenario(base | {"users": 1} | parts, overrides=more)


def test_the_local_model_has_to_be_damped_because_the_device_is_held():
    """B_lm >= 2.97 N s/m with the midpoint rule: G = K T_c/2 + B_lm has to be 3.22 N s/m. As
    published (1 N s/m) it is not stable; the scenario has 8.
    """
    without = {"master.position.gain": 0.0}
    for off, stable in ((-1e-3, False), (1e-3, True)):
        assert bool(radii(scenario(3.2155 - 0.25 + off, **without))[0] < 1.0) is stable
    assert radii(scenario(1.0, **without))[0] > 1.4
    assert radii(scenario(8.0, **LOW_REACHING))[0] < 0.95


def test_a_high_pass_filter_that_reaches_down_brings_the_first_resonance_nearer_to_the_ideal():
    """That of Table 1 attenuates by over 100 dB there and does not move it (App. E, Fig. 6 shows
    it moved).
    """
    peaks = {}
    for name, one in {
        "without": scenario(bank="none"),
        "table": scenario(),
        "low": scenario(8.0, **LOW_REACHING),
    }.items():
        found = transparency(one, np.array([1.0]))
        peak_hz = found.rendered.first_peak_hz
        peaks[name] = peak_hz, abs(transparency(one, np.array([peak_hz])).admittance[0])
    ideal_hz = found.ideal.first_peak_hz
    assert ideal_hz == pytest.approx(10.9, abs=0.15)
    assert peaks["table"][0] == pytest.approx(peaks["without"][0], abs=0.05)
    far, near = (abs(peaks[name][0] - ideal_hz) for name in ("without", "low"))
    assert far - near > 0.9
    assert peaks["low"][1] < 0.6 * peaks["without"][1]
