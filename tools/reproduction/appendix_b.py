# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""App. B: two users on one cube; regions of stability and experiments."""

from typing import Any

import numpy as np

from pmwvc_analysis.maps.maps import Grid, MapAxis, compute
from pmwvc_analysis.models.stability import k_max
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.session import simulate
from reproduction import draw_b
from reproduction.conditions import hold_balance
from reproduction.figure import Figure, Values
from reproduction.scenarios import DELAYS, FRAME_S, pair, scenario
from reproduction.traces import curves, last_mean

BOUND = 1e6
STIFFNESSES = ("user1.server.contact_stiffness", "user2.server.contact_stiffness")
EXPERIMENT_DELAYS = (0, 2, 3)


def region(of: Scenario, *, largest: float, points: int) -> Values:
    """Return spectral radii over both contact stiffnesses, and the largest equal stiffness."""
    axis = tuple(np.linspace(0.0, largest, points).tolist())
    grid = Grid(of, MapAxis(STIFFNESSES[0], axis), MapAxis(STIFFNESSES[1], axis))
    radius = compute(grid, workers=1)
    limit = k_max(of, bound=BOUND)
    return {"k_n_per_m": axis, "radius": radius, "k_max": limit.first, "islands": limit.islands}


def waves(parameters: Values) -> Values:
    """Return the regions of Fig. 2: four delays, two filters."""
    panels, numbers = {}, {}
    for pole in parameters["pole_rad_s"]:
        for delay in parameters["delay_frames"]:
            of = _two(parameters, pole_rad_s=pole, delay=delay)
            found = region(of, largest=parameters["largest"], points=parameters["points"])
            panels[f"{pole:g}/{delay}"] = found
            numbers[f"k_max_pole_{pole:g}_delay_{delay}"] = found["k_max"]
    return {"data": panels, "numbers": numbers | _other_readings(parameters)}


def _two(parameters: Values, *, pole_rad_s: float, delay: int) -> Scenario:
    values = {
        **parameters["model"],
        "master.filter.pole_rad_s": pole_rad_s,
        "link.delay_s": delay * FRAME_S,
    }
    return scenario(values, users=2)


def _other_readings(parameters: Values) -> Values:
    """Return the largest stiffness with other readings of the cut-off and other couplings."""
    numbers: Values = {}
    base = {key: v for key, v in parameters["model"].items() if "pole" not in key}
    cases: dict[str, Values] = {
        "cutoff_50_hz_3_db": {"master.filter.cutoff_hz": 50.0},
        "stop_50_hz_20_db": {"master.filter.stop_hz": 50.0},
        "foh_pole_50": {"master.filter.pole_rad_s": 50.0, "master.hold": "foh"},
        "one_step_delay_forward_pole_50": {
            "master.filter.pole_rad_s": 50.0,
            "server.coupling": "one_step_delay",
            "server.integrator": "forward_euler",
        },
        "one_step_delay_backward_pole_50": {
            "master.filter.pole_rad_s": 50.0,
            "server.coupling": "one_step_delay",
            "server.integrator": "backward_euler",
        },
        "implicit_pole_50": {
            "master.filter.pole_rad_s": 50.0,
            "server.coupling": "implicit",
        },
    }
    for name, changed in cases.items():
        for delay in parameters["delay_frames"]:
            values = {**base, **changed, "link.delay_s": delay * FRAME_S}
            numbers[f"k_max_{name}_delay_{delay}"] = k_max(
                scenario(values, users=2), bound=BOUND
            ).first
    return numbers


def direct(parameters: Values) -> Values:
    """Return the regions of Fig. 3: direct coupling, four delays."""
    panels, numbers = {}, {}
    for delay, largest in zip(parameters["delay_frames"], parameters["largest"], strict=True):
        values = {**parameters["model"], "link.delay_s": delay * FRAME_S}
        of = scenario(values, users=2, controller="direct")
        found = region(of, largest=largest, points=parameters["points"])
        panels[str(delay)] = found
        numbers[f"k_max_delay_{delay}"] = found["k_max"]
    return {"data": panels, "numbers": numbers}


def sessions(parameters: Values) -> Values:
    """Return the curves of an experiment, one session for every delay."""
    runs = [
        scenario(
            {**parameters["model"], "link.delay_s": delay * FRAME_S, **parameters["hands"]},
            users=2,
            operator=parameters["operator"],
            duration_s=parameters["duration_s"],
            task=parameters["task"],
        )
        for delay in parameters["delay_frames"]
    ]
    found: Any = simulate(runs)
    data: Values = {}
    numbers: Values = {}
    for delay, traces in zip(parameters["delay_frames"], found, strict=True):
        full = curves(traces, every_s=0.001)
        half_mm = 500.0 * runs[0].server.object_size_m
        kept = slice(0, round(parameters["shown_s"] * 1e3) + 1, parameters["every_ticks"])
        data[str(delay)] = {name: values[kept] for name, values in full.items()}
        time_s = full["time_s"]
        numbers |= {
            f"force_delay_{delay}_n": last_mean(time_s, full["f_1_n"]),
            f"pressed_delay_{delay}_mm": half_mm
            + last_mean(time_s, full["x_s1_mm"] - full["x_o_mm"]),
            f"ahead_delay_{delay}_mm": last_mean(time_s, full["x_1_mm"] - full["x_s1_mm"]),
            f"cube_reach_delay_{delay}_mm": float(np.max(full["x_o_mm"])),
        }
    numbers["hold_lowest_balance"] = hold_balance(runs[0].users[0].master.rate_drop)
    return {"data": data, "numbers": numbers}


EXPERIMENT = pair(master__hold="foh", server__contact="grip", server__contact_stiffness=500.0)
FIGURES = (
    Figure(
        "B2",
        "Stability region of two users, multirate waves",
        "The cut-offs 50 and 100 are read as the filter's pole in rad/s. One frame late (Eq. 14 "
        "with its sign corrected), forward Euler, zero-order hold.",
        {
            "model": pair(),
            "pole_rad_s": [50.0, 100.0],
            "delay_frames": list(DELAYS),
            "largest": 6000.0,
            "points": 61,
        },
        waves,
        draw_b.waves,
    ),
    Figure(
        "B3",
        "Stability region of two users, multirate direct coupling",
        "Position and velocity are sent each frame; the force comes back and is held. Every "
        "panel has its own scale.",
        {
            "model": pair(),
            "delay_frames": list(DELAYS),
            "largest": [6000.0, 800.0, 120.0, 10.0],
            "points": 61,
        },
        direct,
        draw_b.direct,
    ),
    Figure(
        "B5",
        "Controlled experiments: 1 N from each side on a cube of 500 N/m",
        "Simulated. The hands push from 0.5 s on, when the soft start of the force is over.",
        {
            "model": EXPERIMENT,
            "delay_frames": list(EXPERIMENT_DELAYS),
            "operator": {"kind": "constant", "force": 1.0},
            "hands": {"user2.operator.force": -1.0},
            "duration_s": 12.0,
            "shown_s": 5.0,
            "every_ticks": 10,
            "task": "free",
        },
        sessions,
        draw_b.experiment,
    ),
    Figure(
        "B6",
        "Two hands grip a cube of 500 N/m and carry it along a path",
        "Simulated hands in the place of people: the printed path and people cannot be repeated.",
        {
            "model": EXPERIMENT,
            "delay_frames": list(EXPERIMENT_DELAYS),
            "operator": {"kind": "hand", "stiffness": 120.0, "damping": 15.0, "squeeze": 2.0},
            "hands": {},
            "duration_s": 20.0,
            "shown_s": 20.0,
            "every_ticks": 40,
            "task": "carry",
        },
        sessions,
        draw_b.carry,
    ),
)
