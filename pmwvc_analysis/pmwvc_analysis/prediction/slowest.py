# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The growth or decay of the slowest motion of the exact model, hands off."""

import functools
import math

from pmwvc_analysis.models.links import hyperperiod_ticks
from pmwvc_analysis.models.stability import span
from pmwvc_core.errors import PmwvcError
from pmwvc_core.scenario.scenario import Scenario


@functools.lru_cache(maxsize=64)
def growth_per_s(scenario: Scenario, *, live: bool) -> float | None:
    """Return the rate at which the slowest motion grows [1/s], below zero where it decays; None
    where there is no exact model or it has several answers.
    """
    try:
        found = span(scenario, live=live)
    except PmwvcError:
        return None
    radius = float(found.settled[0])
    if found.stable is None or radius <= 0.0:
        return None
    return math.log(radius) / (hyperperiod_ticks(scenario) * scenario.tick_s)
