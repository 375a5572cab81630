# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""App. D: what a velocity filter is for, and the condition its design comes from."""

import numpy as np

from pmwvc_core.numeric import Array, Complex
from pmwvc_core.wave.velocity_filter_design import POINTS_IN_PHASE, flattest_alpha
from reproduction import draw_d, draw_single
from reproduction.branches import margins
from reproduction.figure import Figure, Values
from reproduction.scenarios import wall
from reproduction.single_user import admittance
from reproduction.velocity import experiment

TICK_S = 1e-3
LOW_POLE = 0.95  # H_LP = 0.05/(z - 0.95), App. D Eq. 15


def best_alpha(*, low_pole: float = LOW_POLE, points: int = POINTS_IN_PHASE) -> float:
    """Return the flattest alpha for H_LP = (1 - p)/(z - p), the numbers of App. D by default."""
    angle, low, _ = printed_branches(0.5, low_pole=low_pole, points=points)
    return flattest_alpha(low, angle, below=low_pole)


def printed_branches(
    alpha: float, *, low_pole: float = LOW_POLE, points: int = POINTS_IN_PHASE
) -> tuple[Array, Complex, Complex]:
    """Return angles [rad per tick] from 0 to below pi, H_LP and H_HP of App. D Eqs. 15 and 16.

    H_LP = (1 - p)/(z - p), H_HP = (z - 1)/(z - alpha).
    """
    angle = np.pi * np.arange(points) / points
    z = np.exp(1j * angle)
    return angle, (1.0 - low_pole) / (z - low_pole), (z - 1.0) / (z - alpha)


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
DESIGNED: Values = {
    "master.velocity_filter.kind": "equivalent",
    "master.velocity_filter.order": 1,
    "master.velocity_filter.alpha": 0.929134319755588,
}
TOUCHED: Values = {
    **MODEL,
    "master.impedance": 30.0,
    "device.mass": 0.5,
    "device.damping": 1.0,
}
FORM = "Velocity filter in the equivalent form (Fig. 2). "
SINE: Values = {"kind": "sinusoid", "force": 1.0, "frequency_hz": 5.0}
STEP: Values = {"kind": "constant", "force": 1.0}
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


def _filtered(name: str, part: str) -> Figure:
    return Figure(
        name,
        f"Transmitted admittance with velocity filter, {part} frequencies",
        REMARK + " Filter of alpha = 0.929 with its loop solved (Fig. 1): the equivalent form "
        "(Fig. 2) is not stable with these impedances and this light device.",
        {
            "model": {**MODEL, **DESIGNED, "master.velocity_filter.kind": "exact"},
            "impedances": [10.0, 25.0, 50.0, 80.0],
            "low_hz": [0.05, 3.0],
            "high_hz": [3.0, 60.0],
            "parts": [part],
        },
        admittance,
        draw_single.admittance,
    )


def _experiment(name: str, words: str, filtered: Values, operator: Values, remark: str) -> Figure:
    return Figure(
        name,
        words,
        "Simulated: encoder of 60 um, velocity from its differences, b = 30 Ns/m, loop solved, "
        "m = 0.5 kg, b_hd = 1 Ns/m. " + (FORM if filtered else "No velocity filter. ") + remark,
        {
            "model": {**TOUCHED, **filtered},
            "device": {"device.encoder_step_m": 6e-5, "device.velocity": "euler"},
            "operator": operator,
            "duration_s": 4.0,
            "from_s": 0.5,
            "delays_s": [0.02, 0.1] if filtered else [],
        },
        experiment,
        draw_single.contact,
    )


FIGURES = (
    _admittance("D3", "low"),
    _admittance("D4", "high"),
    _filtered("D6", "low"),
    _filtered("D7", "high"),
    _experiment("D8", "5 Hz against the wall, without velocity filter", {}, SINE, ""),
    _experiment(
        "D9",
        "5 Hz against the wall, with an inappropriate velocity filter",
        {**DESIGNED, "master.velocity_filter.alpha": 0.95},
        SINE,
        "LP_v = 0.05/(z - 0.95). The force grows up to the safety limit, 20 N here.",
    ),
    _experiment(
        "D10", "5 Hz against the wall, with the designed velocity filter", DESIGNED, SINE, ""
    ),
    _experiment("D11", "A step against the wall, without velocity filter", {}, STEP, ""),
    _experiment("D12", "A step against the wall, with the velocity filter", DESIGNED, STEP, ""),
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
