# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Computations that several appendices share: one user at a wall."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from pmwvc_analysis.models.linearize import build, spectral_radius
from pmwvc_analysis.models.stability import StabilityLimit, k_max
from pmwvc_analysis.transparency.transparency import transparency
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.names import varied
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.session import simulate
from reproduction.figure import Values
from reproduction.scenarios import UNLIMITED, scenario
from reproduction.simulated_width import simulated_z_width
from reproduction.traces import curves, last_mean, limited_ticks

BOUND = 1e6
REFINEMENTS, FINER = 3, 9  # of the grid around the largest stiffness


def admittance(parameters: Values) -> Values:
    """Return transmitted admittances over frequency for several wave impedances, and the ideal."""
    scenarios = {
        f"b_{impedance:g}": scenario(
            {**parameters["model"], "master.impedance": impedance}, users=1
        )
        for impedance in parameters["impedances"]
    }
    low = np.linspace(parameters["low_hz"][0], parameters["low_hz"][1], 81)
    high = np.linspace(parameters["high_hz"][0], parameters["high_hz"][1], 161)
    return admittances_of(scenarios, low, high)


def admittances_of(scenarios: dict[str, Scenario], low_hz: Array, high_hz: Array) -> Values:
    """Return |x/f| of every scenario and of the ideal coupling, stiffness and first peak."""
    hertz, split = np.concatenate([low_hz, high_hz]), len(low_hz)
    data: Values = {"low_hz": low_hz, "high_hz": high_hz}
    numbers: Values = {}
    for name, of in scenarios.items():
        found = transparency(of, hertz)
        for key, values, rendered in (
            (name, found.admittance, found.rendered),
            ("ideal", found.ideal_admittance, found.ideal),
        ):
            size = np.abs(values)
            data[key] = {"low": size[:split], "high": size[split:]}
            numbers[f"k_felt_{key}"] = rendered.k_felt
            numbers[f"first_peak_hz_{key}"] = rendered.first_peak_hz
    return {"data": data, "numbers": numbers}


def z_width(scenario: Scenario, damping: Sequence[float]) -> list[StabilityLimit]:
    """Return the largest stiffness for each contact damping [N s/m] that can be rendered."""
    return [k_max(varied(scenario, "server.contact_damping", b)) for b in damping]


def widths(parameters: Values) -> Values:
    """Return the largest stable stiffness over the wall's damping, for several connections."""
    damping = np.linspace(*parameters["damping"])
    data: Values = {"damping": damping}
    numbers: Values = {}
    for name, changed in parameters["curves"].items():
        values = {**parameters["model"], **changed["values"]}
        of = scenario(values, users=1, controller=changed.get("controller", "pmwvc"))
        at = float(parameters["at_damping"])
        asked = list(dict.fromkeys([*damping.tolist(), at]))
        if "highest" in changed:  # not linear: from sessions
            limits = _simulated(of, asked, changed["highest"])
        else:
            limits = [limit.first for limit in z_width(of, asked)]
        found = dict(zip(asked, limits, strict=True))
        data[name] = [found[b] for b in damping.tolist()]
        firsts = [first for first in data[name] if first is not None]
        largest = max(firsts) if len(firsts) == len(damping) else None
        if largest is not None and "highest" not in changed:
            largest = _largest(of, damping, firsts)
        numbers[f"largest_{name}"] = largest
        numbers[f"at_{at:g}_{name}"] = found[at]
    return {"data": data, "numbers": numbers}


def _largest(of: Scenario, damping: Array, firsts: list[float]) -> float:
    """Return the largest stiffness over all damping, searched between the points of the grid."""
    known = dict(zip(damping.tolist(), firsts, strict=True))
    for _ in range(REFINEMENTS):
        top = int(np.argmax(firsts))
        damping = np.linspace(
            damping[max(top - 1, 0)], damping[min(top + 1, len(damping) - 1)], FINER
        )
        asked = [b for b in dict.fromkeys(damping.tolist()) if b not in known]
        limits = z_width(of, asked)
        known |= {b: limit.first or 0.0 for b, limit in zip(asked, limits, strict=True)}
        firsts = [known[b] for b in damping.tolist()]
    return max(firsts)


def _simulated(of: Scenario, damping: list[float], highest: float) -> list[float | None]:
    """Return the middle of the bracket of each largest stiffness; None beyond the highest."""
    brackets = [simulated_z_width(of, b, highest=highest) for b in damping]
    return [None if high is None else 0.5 * (low + high) for low, high in brackets]


def contact(parameters: Values) -> Values:
    """Return a simulated contact, and how stable its model is with the loop delayed and solved."""
    model = parameters["model"]
    of = scenario(
        {**model, **UNLIMITED, "server.contact": "grip"},
        users=1,
        operator=parameters["operator"],
        duration_s=parameters["duration_s"],
    )
    traces: Any = simulate([of])[0]
    full = curves(traces, every_s=0.001)
    wall_mm = -500.0 * of.server.object_size_m
    late = full["time_s"] > 0.5 * parameters["duration_s"]
    kept = slice(0, None, parameters["every_ticks"])
    data = {
        "time_s": full["time_s"][kept],
        "x_m_mm": full["x_1_mm"][kept] - wall_mm,
        "x_s_mm": full["x_s1_mm"][kept] - wall_mm,
        "f_m_n": full["f_1_n"][kept],
        "f_s_n": full["f_s1_n"][kept],
    }
    solved = {**model, "server.coupling": "unwrapped", "server.integrator": "trapezoid"}
    numbers = {
        "spectral_radius": radius_of(model),
        "spectral_radius_loop_solved": radius_of(solved),
        "force_end_n": last_mean(full["time_s"], full["f_1_n"]),
        "force_swing_n": _swing(full["f_1_n"][late]),
        "position_swing_mm": _swing(full["x_1_mm"][late]),
        "limited_ticks": limited_ticks(traces),
        "depth_end_mm": last_mean(full["time_s"], full["x_s1_mm"]) - wall_mm,
    }
    return {"data": data, "numbers": numbers}


def radius_of(model: Values) -> float:
    """Return the spectral radius of one user's loop."""
    return spectral_radius(build(scenario(model, users=1)))


def _swing(values: Array) -> float:
    return float(np.nanmax(values) - np.nanmin(values))
