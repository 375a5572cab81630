# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A point of a stability map by itself, computed without batches."""

from pmwvc_analysis.models.stability import radii
from pmwvc_core.scenario.names import varied


def point(grid, row, place):
    """Return the spectral radius at one point of a map."""
    scenario = varied(grid.scenario, grid.y.name, grid.y.values[row])
    scenario = varied(scenario, grid.x.name, grid.x.values[place])
    return float(radii(scenario, live=grid.live)[0])
