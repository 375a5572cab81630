# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Position feedback that adapts has the gain 0.5 sqrt(2b)/tau, with the tau that the channel shows
as a spring: F tau/(2b) is how far a device stands ahead of its avatar without feedback.
"""

import math

import numpy as np
import pytest
from support.simulated import simulated

from pmwvc_bringup import scenarios

B = 25.0
LENT = ("master.position.storage_j=0.02",)
PRESS = (
    *("server.contact=bilateral", "link.delay_s=0.016", "device.damping=4"),
    *("operator.kind=constant", "operator.force=1"),
)


def pressed(channel, *settings):
    texts = [f"channel={channel}", *PRESS, *settings]
    traces = simulated(scenarios.load("wall", settings_texts=texts, duration_s=3.0))
    return traces.users[0], traces.server.x_s[0][-1, 0]


@pytest.mark.parametrize("channel", ["plain", "strict"])
def test_a_gain_that_adapts_is_that_of_the_round_trip_which_the_offset_shows(channel):
    user, avatar = pressed(channel)
    tau_s = 2.0 * B * (user.x_m[-1, 0] - avatar) / user.f_applied[-1, 0]
    assert 0.035 < tau_s < 0.045  # 32 ms of delay, and frame, step and hold
    gain = 0.5 * math.sqrt(2.0 * B) / tau_s
    adapts, _ = pressed(channel, *LENT, "master.position.adapts=true")
    same, double = (pressed(channel, *LENT, f"master.position.gain={k * gain}")[0] for k in (1, 2))
    apart, control = (np.abs(adapts.x_m - each.x_m).max() for each in (same, double))
    assert apart < 0.2 * control
    assert control > 1e-4
