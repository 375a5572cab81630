# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A session that ends while the hands close: their motion is no oscillation of the loop."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support import plain as scenarios
from support.handmade import oscillating

from pmwvc_analysis.models.stability import radii
from pmwvc_analysis.traces.stages import until
from pmwvc_analysis.verdicts.stability import verdict
from pmwvc_core.simulation.session import simulate_one


def instabilities(traces, scenario):
    """The instability found in the session as it would have been, had it ended at any time."""
    ends_s = np.arange(0.9, traces.duration_s, 0.3)
    return {round(s, 1): verdict(until(traces, s), scenario).instability for s in ends_s}


@settings(max_examples=3)
@given(
    rise_s=st.floats(0.3, 2.0),
    squeeze_n=st.floats(0.3, 2.5),
    gap_m=st.floats(0.0, 0.03),
    name=st.sampled_from(["wall", "carry_16ms"]),
)
def test_a_stable_session_is_never_called_unstable_whenever_it_ends(
    rise_s, squeeze_n, gap_m, name
):
    texts = [
        f"task.grip_rise_s={rise_s}", f"operator.squeeze={squeeze_n}", f"server.gap_m={gap_m}",
    ]  # fmt: skip
    scenario = scenarios.load(name, settings_texts=texts, duration_s=5.0)
    assert radii(scenario).max() < 1.0
    found = instabilities(simulate_one(scenario), scenario)
    assert {end_s: kind for end_s, kind in found.items() if kind} == {}


@pytest.mark.parametrize("hertz", [10.0, 60.0])
def test_a_vibration_while_the_hands_close_is_found(hertz):
    """The control."""
    scenario = scenarios.load("wall", duration_s=2.0)
    traces = oscillating(simulate_one(scenario), rms_m_s=20e-3, hertz=hertz)
    assert verdict(traces, scenario).instability == "sustained oscillation"
