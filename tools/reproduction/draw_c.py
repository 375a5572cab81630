# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Drawings of App. C that no other appendix has."""

from typing import Any

import numpy as np

from pmwvc_analysis.charts import style
from reproduction.drawing import EDGE, REGION, colour_of, numbers, sheet
from reproduction.figure import Values

CASES = {"unwrapped": "1) loop unwrapped", "one_step_delay": "2) one step of delay"}
WHOSE = {"printed": "as printed", "loop": "consistent diagram"}


def regions(result: Values) -> Any:
    """Fig. 3: alpha over beta; printed above, ours below."""
    rows = result["parameters"]["rows"]
    figure, axes = sheet(result, len(rows), 2, size_in=(8.6, 10.0))
    for row, line in zip(rows, axes, strict=True):
        for (case, words), panel in zip(CASES.items(), line, strict=True):
            name = f"{row['polynomial']}_sigma_{row['sigma']:g}_{case}"
            found = result["data"][name]
            beta, low, high = (numbers(found[key]) for key in ("beta", "low", "high"))
            if np.isfinite(low).any():
                known = np.isfinite(low)
                across = np.concatenate([beta[known], beta[known][::-1]])
                around = np.concatenate([high[known], low[known][::-1]])
                panel.fill(across, around, facecolor=REGION, edgecolor=EDGE, lw=1.2)
            else:
                panel.text(0.5, 0.5, "nothing is stable", ha="center", transform=panel.transAxes)
            panel.set_xlim(0.0, found["window"][1])
            panel.set_ylim(0.0, found["window"][0])
            panel.set_xlabel("β = b T/m")
            panel.set_ylabel("α = K T²/m")
            panel.set_title(f"{words}, {WHOSE[row['polynomial']]}, σ = {row['sigma']:g}", size=10)
    return figure


def energies(result: Values) -> Any:
    """Fig. 5: positions, forces, and where the energy is; what compensation gains."""
    figure, axes = sheet(result, 4, 1, size_in=(7.6, 11.2))
    data = {name: numbers(values) for name, values in result["data"].items()}
    above, middle, below, gain = axes[:, 0]
    for panel, unit, words in ((above, "mm", "x"), (middle, "n", "F")):
        letter = words.lower()
        for side, colour in (("s", style.LIGHT_USERS[1]), ("m", style.LIGHT_USERS[0])):
            panel.plot(data["time_s"], data[f"{letter}_{side}_{unit}"], color=colour,
                       label=f"${words}_{side}$", linewidth=1.2)  # fmt: skip
    for place, (name, label) in enumerate(
        (
            ("environment", "environment"),
            ("late_decoding", "computational delay"),
            ("before", "port before compensation"),
            ("after", "port after compensation"),
        )
    ):
        below.plot(
            data["step_s"], data[f"{name}_mj"], label=label, color=colour_of(place),
            linewidth=3.0 if name == "environment" else 1.4,
        )  # fmt: skip
    below.axhline(0.0, color=style.LIGHT["target"], linewidth=0.8)
    above.set_title("(a) Positions of the device $x_m$, and commanded in the VE $x_s$")
    middle.set_title("(b) Forces applied to the user $F_m$, and computed in the VE $F_s$")
    below.set_title("(c) Energy balances")
    above.set_ylabel("depth in the wall [mm]")
    middle.set_ylabel("force [N]")
    below.set_ylabel("energy [mJ]")
    for panel in (above, middle, below):
        panel.set_xlim(0.0, data["time_s"][-1])
        panel.set_xlabel("time [s]")
        panel.legend(loc="best", fontsize=8)
    _stiffness(gain, result)
    return figure


def _stiffness(panel: Any, result: Values) -> None:
    """Draw the largest stable stiffness without and with compensation, over the wall's damping."""
    damping, found = result["parameters"]["stiffness"]["damping"], result["numbers"]
    for place, (name, label) in enumerate((("none", "without"), ("corrected", "corrected"))):
        values = [found[f"largest_{name}_at_{b:g}"] for b in damping]
        panel.plot(damping, values, "o-", label=label, color=colour_of(place))
    for b in damping:
        factor, top = found[f"factor_at_{b:g}"], found[f"largest_corrected_at_{b:g}"]
        panel.annotate(f"× {factor:.2f}", (b, top), xytext=(6, -12), textcoords="offset points")
    panel.margins(x=0.15)
    panel.set_ylim(bottom=0.0)
    panel.set_title("(d) Largest stable stiffness, 0.1 N of friction and an encoder of 55 µm")
    panel.set_xlabel("damping of the wall [N s/m]")
    panel.set_ylabel("stiffness [N/m]")
    panel.legend(loc="best", fontsize=8)
