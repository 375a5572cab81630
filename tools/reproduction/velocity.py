# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""App. D: sessions with a coarse encoder, without and with a velocity filter."""

from typing import Any

import numpy as np

from pmwvc_analysis.models.linearize import build, spectral_radius
from pmwvc_analysis.traces.sums import beyond, rms
from pmwvc_core.simulation.session import simulate_one
from reproduction.conditions import radii_over_delay
from reproduction.figure import Values
from reproduction.scenarios import UNLIMITED, scenario
from reproduction.traces import curves, limited_ticks

NOISE_HZ = 60.0  # above it there is nothing but noise in the force


def experiment(parameters: Values) -> Values:
    """Return positions and forces of a session, and how noisy and how large the force is."""
    model = parameters["model"]
    of = scenario(
        {**model, **UNLIMITED, **parameters["device"]},
        users=1,
        operator=parameters["operator"],
        duration_s=parameters["duration_s"],
    )
    traces: Any = simulate_one(of)
    full = curves(traces, every_s=0.001)
    wall_mm = -500.0 * of.server.object_size_m
    shown = full["time_s"] >= parameters["from_s"]
    data = {
        "time_s": full["time_s"][shown] - parameters["from_s"],
        "x_m_mm": full["x_1_mm"][shown] - wall_mm,
        "x_s_mm": full["x_s1_mm"][shown] - wall_mm,
        "f_m_n": full["f_1_n"][shown],
        "f_s_n": full["f_s1_n"][shown],
    }
    user = traces.users[0]
    late = user.time_s > 0.5 * parameters["duration_s"]
    numbers = {
        "force_noise_n": rms(beyond(user.f_m, user.tick_s, NOISE_HZ)[late]),
        "force_largest_n": float(np.abs(full["f_1_n"]).max()),
        "limited_ticks": limited_ticks(traces),
        "spectral_radius": spectral_radius(build(scenario(model, users=1))),
    }
    numbers |= radii_over_delay(model, parameters["delays_s"])
    return {"data": data, "numbers": numbers}
