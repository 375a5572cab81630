# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""App. D: what a velocity filter is for, and the condition its design comes from."""

import numpy as np

from pmwvc_analysis.reproduction import draw_d, draw_single
from pmwvc_analysis.reproduction.figure import Figure, Values
from pmwvc_analysis.reproduction.scenarios import wall
from pmwvc_analysis.reproduction.single_user import admittance
from pmwvc_core.wave.branches import margins
from pmwvc_core.wave.velocity_filter_design import best_alpha, printed_branches

TICK_S = 1e-3


def condition(parameters: Values) -> Values:
    """Return the right-hand side of Eq. 14 over frequency, and what is left of both conditions."""
    data: Values = {}
    numbers: Values = {}
    ours = best_alpha(low_pole=parameters["low_pole"], points=parameters["points"])
    for name, alpha in (("printed", parameters["alpha"]), ("ours", ours)):
        angle, low, high = printed_branches(
            alpha, low_pole=parameters["low_pole"], points=parameters["points"]
        )
        found = margins(low, high, angle / (2.0 * np.pi * TICK_S))
        data["angle_over_pi"] = angle / np.pi
        data[f"in_phase_{name}"] = found["in_phase"]
        data[f"any_environment_{name}"] = found["any_environment"]
        data[f"velocity_gain_{name}"] = np.abs(1.0 - high)
        numbers |= {
            f"alpha_{name}": alpha,
            f"in_phase_largest_{name}": 1.0 - found["in_phase_margin"],
            f"any_environment_largest_{name}": 1.0 - found["any_environment_margin"],
        }
    return {"data": data, "numbers": numbers}


MODEL = wall(
    master__filter__kind="first_order",
    master__filter__pole_rad_s=float(-np.log(0.95) / TICK_S),
    server__contact_stiffness=2000.0,
    server__contact_damping=10.0,
)
MODEL = {name: value for name, value in MODEL.items() if not name.endswith(("pass_hz", "stop_hz"))}
REMARK = (
    "LP is Eq. 15, 0.05/(z - 0.95). The device is not given: m = 0.15 kg, b_hd = 1 Ns/m as in "
    "App. A; trapezoid, loop solved."
)


def _admittance(name: str, part: str) -> Figure:
    return Figure(
        name,
        f"Transmitted admittance for several wave impedances, {part} frequencies",
        REMARK,
        {
            "model": MODEL,
            "impedances": [10.0, 25.0, 50.0, 80.0],
            "low_hz": [0.05, 3.0],
            "high_hz": [3.0, 60.0],
            "parts": [part],
        },
        admittance,
        draw_single.admittance,
    )


FIGURES = (
    _admittance("D3", "low"),
    _admittance("D4", "high"),
    Figure(
        "D5",
        "Objective function of the filter design over frequency",
        "Eq. 14 takes the environment to reflect in phase; dashed: the condition for any passive "
        "environment, |H_LP| + |H_HP|/2 <= 1.",
        {"alpha": 0.929134319755588, "low_pole": 0.95, "points": 512},
        condition,
        draw_d.condition,
    ),
)
