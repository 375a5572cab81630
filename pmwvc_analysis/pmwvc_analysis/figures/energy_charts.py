# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The figure of the energy budget over time."""

import numpy as np

from pmwvc_analysis.budget.budget import budget
from pmwvc_analysis.budget.parts import group_of
from pmwvc_analysis.budget.result import Budget
from pmwvc_analysis.charts.chart import Chart, Curve, Layer, Panel
from pmwvc_analysis.charts.style import user_tint
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces

ORDER = (
    "devices", "sampling and safety", "filters and holds", "links", "server's computation",
    "contacts", "object", "controller",
)  # fmt: skip
MOST_POINTS = 1500


def whereabouts(traces: SessionTraces, scenario: Scenario | None) -> Chart | None:
    """Return where the energy of the hands is, stacked."""
    found = budget(traces, scenario)
    if found is None or len(found.time_s) < 2:
        return None
    kept = slice(None, None, max(1, len(found.time_s) // MOST_POINTS))
    given = np.asarray(sum(found.hands.values()), dtype=float)
    groups = grouped(found)
    smallest = 1e-4 * max(float(np.abs(series).max()) for series in groups.values())
    groups = {name: sums for name, sums in groups.items() if np.abs(sums).max() > smallest}
    unit, scale = unit_of(np.concatenate([*groups.values(), given]))
    time_s = found.time_s[kept]
    hands = [Curve("given by the hands", time_s, given[kept] * scale, "object", (), 1.8)]
    layers = _stack(time_s, {name: sums[kept] * scale for name, sums in groups.items()})
    return Chart(
        "budget",
        "Energy budget",
        "Energy given by the hands (black) and where it is: stored, dissipated, or in flight. "
        "Areas below zero are energy that was generated.",
        [Panel(f"energy [{unit}]", hands, layers=layers, with_zero=True, height=280.0)],
    )


def _stack(time_s: Array, groups: dict[str, Array]) -> list[Layer]:
    """Return the groups stacked: what is positive upwards, what is negative downwards."""
    layers, rises, falls = [], np.zeros(len(time_s)), np.zeros(len(time_s))
    for index, name in enumerate(ORDER):
        if name not in groups:
            continue
        sums = groups[name]
        higher, lower = rises + np.maximum(sums, 0.0), falls + np.minimum(sums, 0.0)
        layers.append(Layer(name, time_s, rises, higher, user_tint(index), index))
        if (sums < 0.0).any():
            layers.append(Layer(name, time_s, lower, falls, user_tint(index), index))
        rises, falls = higher, lower
    return layers


def grouped(found: Budget) -> dict[str, Array]:
    """Return the energies of all owners by group [J]."""
    sums: dict[str, Array] = {}
    for parts in found.parts.values():
        for part, series in parts.items():
            name = group_of(part)
            sums[name] = sums.get(name, 0.0) + series
    return sums


def unit_of(values: Array) -> tuple[str, float]:
    """Return the unit in which values are read best, and its factor."""
    return ("J", 1.0) if np.nanmax(np.abs(values), initial=0.0) >= 1.0 else ("mJ", 1e3)
