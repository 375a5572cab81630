# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""App. E, as far as it needs no filter bank: waves alone at a wall of 500 N/m."""

from pmwvc_analysis.reproduction import draw_single
from pmwvc_analysis.reproduction.figure import Figure
from pmwvc_analysis.reproduction.scenarios import wall
from pmwvc_analysis.reproduction.single_user import admittance, widths

DEVICE = {"device.mass": 0.1, "device.damping": 1.5}
MODEL = {
    **wall(server__contact_stiffness=500.0, server__contact_damping=1.0),
    **DEVICE,
}
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
)
