# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What the page of faults asks of a force: less than a blow, and little time without it."""

import numpy as np
import pytest
from faults.fault import undisturbed
from support import handmade

from pmwvc_analysis.verdicts.verdicts import summary


def asked(traces):
    return undisturbed(summary(traces, handmade.scenario(duration_s=6.0)))


@pytest.mark.parametrize("step_n", [0.0, 0.2, 0.4, 1.5])  # the slew limit lets 2 N through
def test_a_step_of_force_that_a_hand_feels_does_not_hold(step_n):
    traces = handmade.session(duration_s=6.0)
    traces.users[0].f_applied[4000:] += step_n
    held, text = asked(traces)
    assert held is (step_n < 0.3)
    assert f"step {max(step_n, 0.01):.2f} N" in text


@pytest.mark.parametrize("missing_s", [0.05, 0.2])
def test_a_force_that_is_missing_for_longer_than_a_grip_takes_to_react_does_not_hold(missing_s):
    traces = handmade.session(duration_s=6.0)
    user = traces.users[0]
    edges = 4.00025 + np.array([0.0, 0.01, 0.01 + missing_s, 0.02 + missing_s])
    user.f_applied *= np.interp(user.time_s, edges, (1.0, 0.0, 0.0, 1.0))[:, np.newaxis]
    held, text = asked(traces)
    assert held is (missing_s < 0.1)
    assert f"least force 0.00 N, below half for {1e3 * (missing_s + 0.01):.0f} ms" in text
