# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The growth or decay of the slowest motion of the exact model, hands off."""

import math

from pmwvc_analysis.models.links import hyperperiod_ticks
from pmwvc_analysis.prediction.prediction import Exact, exact
from pmwvc_core.scenario.scenario import Scenario


def growth_per_s(scenario: Scenario, *, live: bool) -> float | None:
    """Return the rate at which the slowest motion grows [1/s], below zero where it decays; None
    where there is no exact model.
    """
    found = exact(scenario, live=live)
    if not isinstance(found, Exact) or found.spectral_radius <= 0.0:
        return None
    return math.log(found.spectral_radius) / (hyperperiod_ticks(scenario) * scenario.tick_s)
