# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""App. E: waves alone at a wall of 500 N/m, and with a filter bank and a local model."""

from reproduction import draw_e, draw_single, local_model
from reproduction.figure import Figure, Values
from reproduction.scenarios import wall
from reproduction.single_user import admittance, widths

DEVICE = {"device.mass": 0.1, "device.damping": 1.5}
MODEL = {
    **wall(server__contact_stiffness=500.0, server__contact_damping=1.0),
    **DEVICE,
}
# HP of Table 1 passes nothing of the first resonance; the other one does.
BANK: Values = {
    "master.bank.kind": "dissertation",
    "master.local_model.stiffness": 500.0,
    "master.local_model.damping": 5.0,
    "master.position.feedback": "printed",
    "master.position.gain": 20.0,
}
LOWER: Values = {
    "master.bank.high_pass_hz": 4.0,
    "master.bank.high_pass_db": 3.0,
    "master.bank.high_stop_hz": 0.4,
    "master.bank.high_stop_db": 20.0,
}
CURVES: Values = {
    "waves": {"label": "multirate waves (PMW)", "values": {}},
    "table": {"label": "PMW + LM, HP of Table 1", "values": BANK},
    "bank": {"label": "PMW + LM, HP of first order, 4 Hz", "values": {**BANK, **LOWER}},
}
DELAYED: Values = {
    **MODEL,
    "server.coupling": "one_step_delay",
    "server.integrator": "backward_euler",
}
DAMPED = "B_LM = 5 Ns/m: with the 1 Ns/m of the environment the loop is unstable. "
FIGURES = (
    Figure(
        "E2",
        "Transmitted admittance, direct coupling and multirate waves",
        "Table 1 read as Butterworth 25/50 Hz, 20/40 dB; trapezoid, loop solved.",
        {
            "model": MODEL,
            "impedances": [10.0, 25.0, 50.0],
            "low_hz": [0.05, 3.0],
            "high_hz": [3.0, 50.0],
            "parts": ["low", "high"],
        },
        admittance,
        draw_single.admittance,
    ),
    Figure(
        "E4",
        "Z-width with multirate waves, b = 25 Ns/m",
        "One step of delay; the printed 800 N/m at 1 Ns/m is met by no reading of the text tried.",
        {
            "model": {**MODEL, "server.coupling": "one_step_delay"},
            "damping": [0.0, 20.0, 21],
            "at_damping": 1.0,
            "curves": {
                "backward": {
                    "label": "backward Euler",
                    "values": {"server.integrator": "backward_euler"},
                },
                "trapezoid": {
                    "label": "trapezoid",
                    "values": {"server.integrator": "trapezoid"},
                },
                "forward": {
                    "label": "forward Euler",
                    "values": {"server.integrator": "forward_euler"},
                },
            },
        },
        widths,
        draw_single.widths,
    ),
    Figure(
        "E5",
        "Largest stiffness with filter bank and local model, b = 25 Ns/m",
        DAMPED + "One step of delay, backward Euler, B_VE = 1 Ns/m, filters of Table 1.",
        {
            "model": {**DELAYED, **BANK},
            "plain": DELAYED,
            "local_stiffness": [0.0, 1000.0, 11],
            "gains": [0.0, 10.0, 20.0, 40.0],
            "banks": {"table": {}, "lower": LOWER},
        },
        local_model.limits,
        draw_e.limits,
    ),
    Figure(
        "E6",
        "Transmitted admittance with filter bank, local model and position feedback",
        DAMPED + "K_p = 20 √W/m, trapezoid, loop solved.",
        {
            "model": MODEL,
            "curves": CURVES,
            "low_hz": [0.05, 3.0, 81],
            "high_hz": [3.0, 50.0, 161],
        },
        local_model.admittances,
        draw_e.admittances,
    ),
    Figure(
        "E7",
        "Transmitted admittance as a sweep of 0 to 50 Hz shows it",
        DAMPED + "Simulated sweeps of 1 N; K_p = 20 √W/m, trapezoid, loop solved.",
        {
            "model": MODEL,
            "curves": CURVES,
            "session": {
                "duration_s": 42.0,
                "operator": {
                    "kind": "chirp",
                    "force": 1.0,
                    "frequency_hz": 0.0,
                    "frequency_end_hz": 50.0,
                    "sweep_s": 40.0,
                },
            },
        },
        local_model.measured,
        draw_e.measured,
    ),
    Figure(
        "E8",
        "Impedance transmitted to the user, F_m/X_m",
        DAMPED + "K_p = 20 √W/m, trapezoid, loop solved.",
        {"model": MODEL, "curves": CURVES, "hz": [0.05, 50.0, 200]},
        local_model.impedances,
        draw_e.impedances,
    ),
)
