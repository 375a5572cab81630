# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""App. C: the computational delay of an unknown environment."""

import numpy as np

from reproduction import compensation, draw_c, draw_single
from reproduction.characteristic import (
    CASES,
    jury_marden,
    loop_polynomial,
    printed_polynomial,
)
from reproduction.figure import Figure, Values
from reproduction.scenarios import wall
from reproduction.single_user import widths

UNKNOWN = {"server.coupling": "unknown", "server.decoding": "late"}
POLYNOMIALS = {"printed": printed_polynomial, "loop": loop_polynomial}


def regions(parameters: Values) -> Values:
    """Return where the polynomials have all roots inside the unit circle: over beta the lowest and
    the highest stable alpha, and the areas.
    """
    data: Values = {}
    numbers: Values = {}
    for row in parameters["rows"]:
        for case in CASES:
            name = f"{row['polynomial']}_sigma_{row['sigma']:g}_{case}"
            window = row["windows"][case]
            found, area = _region(row, case, window, parameters["points"])
            data[name] = {**found, "window": window}
            numbers[f"area_{name}"] = area
            tall = _region(row, case, [4.0 * window[0], window[1]], parameters["points"])[1]
            numbers[f"area_{name}_window_four_times_as_high"] = tall
    for row in parameters["rows"]:
        name = f"{row['polynomial']}_sigma_{row['sigma']:g}"
        solved, late = (numbers[f"area_{name}_{case}"] for case in CASES)
        numbers[f"ratio_{name}"] = late / solved if solved > 0.0 else None
    return {"data": data, "numbers": numbers}


def _region(row: Values, case: str, window: list[float], points: int) -> tuple[Values, float]:
    """Return a region up to the largest alpha and beta of a window, and its area."""
    alpha = np.linspace(0.0, window[0], 4 * points + 1)[1:]
    beta = np.linspace(0.0, window[1], points + 1)[1:]
    across, up = np.meshgrid(alpha, beta)
    polynomial = POLYNOMIALS[row["polynomial"]]
    inside = np.asarray(jury_marden(polynomial(case, across, up, row["sigma"] + 0.0 * across)))
    any_stable = inside.any(axis=1)
    low = np.where(any_stable, alpha[np.argmax(inside, axis=1)], np.nan)
    high = np.where(any_stable, alpha[::-1][np.argmax(inside[:, ::-1], axis=1)], np.nan)
    area = float(inside.mean() * alpha[-1] * beta[-1])
    return {"beta": beta, "low": low, "high": high}, area


FIGURES = (
    Figure(
        "C3",
        "Stability regions with the loop unwrapped and with one step of delay",
        "Above: the printed polynomials (Eq. 6 and 7), which do not follow from one diagram; "
        "unwrapped they are stable for any alpha, so that region goes on above the panel. Below: "
        "both cases of one consistent diagram; without damping a sampled mass gives out a little "
        "energy that nothing takes, so no region is left; with sigma = 0.2 there is one. Every "
        "panel has its own scale.",
        {
            "points": 200,
            "rows": [
                {
                    "polynomial": "printed",
                    "sigma": 0.0,
                    "windows": {"unwrapped": [4.0, 1.2], "one_step_delay": [0.4, 1.2]},
                },
                {
                    "polynomial": "loop",
                    "sigma": 0.0,
                    "windows": {"unwrapped": [0.5, 1.0], "one_step_delay": [0.5, 1.0]},
                },
                {
                    "polynomial": "loop",
                    "sigma": 0.2,
                    "windows": {"unwrapped": [0.5, 1.0], "one_step_delay": [0.5, 1.0]},
                },
            ],
        },
        regions,
        draw_c.regions,
    ),
    Figure(
        "C4",
        "Z-width with waves and direct coupling, b = 25 Ns/m",
        "m = 0.15 kg, b_hd = 1 Ns/m, Butterworth 25/50 Hz, one step of delay, backward Euler. "
        "Without compensation from the exact model; with it, which is not linear, by bisection "
        "over simulated sessions.",
        {
            "model": wall(server__coupling="one_step_delay", server__integrator="backward_euler"),
            "damping": [0.0, 30.0, 31],
            "at_damping": 0.0,
            "curves": {
                "waves": {"label": "multirate waves, no compensation", "values": {}},
                "direct": {
                    "label": "direct coupling",
                    "controller": "direct",
                    "values": {},
                },
                "printed": {
                    "label": "compensation as printed (Eq. 15)",
                    "values": {**UNKNOWN, "server.compensation": "printed"},
                    "highest": 4000.0,
                },
                "corrected": {
                    "label": "compensation corrected (debt carried)",
                    "values": {**UNKNOWN, "server.compensation": "corrected"},
                    "highest": 4000.0,
                },
                "ledger": {
                    "label": "port ledger",
                    "values": {**UNKNOWN, "server.compensation": "ledger"},
                    "highest": 4000.0,
                },
            },
        },
        widths,
        draw_single.widths,
    ),
    Figure(
        "C5",
        "Contact with a wall of 500 N/m under energetic compensation",
        "Simulated hand; compensation with the debt carried, since the printed one makes energy. "
        "Trapezoid: with backward Euler the balance is never below zero, K T < b.",
        {
            "model": wall(
                server__contact_stiffness=500.0,
                server__contact_damping=0.0,
                server__coupling="unknown",
                server__decoding="late",
                server__integrator="trapezoid",
            ),
            "operator": {"kind": "hand"},
            "duration_s": 6.0,
            "drawn": "corrected",
            "stiffness": {
                "model": wall(
                    server__coupling="unknown",
                    server__decoding="late",
                    server__integrator="trapezoid",
                ),
                "device": {
                    "device.friction": 0.1,
                    "device.encoder_step_m": 55e-6,
                    "device.velocity": "euler",
                },
                "damping": [0.0, 5.0, 15.0],
                "grid": [100.0, 3401.0, 50.0],
                "force": 1.0,
                "duration_s": 6.0,
            },
        },
        compensation.contact,
        draw_c.energies,
    ),
)
