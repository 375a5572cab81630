# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Drawings of one user at a wall."""

from typing import Any

import numpy as np

from pmwvc_analysis.charts import style
from reproduction.drawing import LINES, OBJECT, colour_of, numbers, sheet
from reproduction.figure import Values

TICK_HZ = 1000.0


def admittance(result: Values) -> Any:
    """Draw the ideal dotted, the waves by impedance, low and high frequencies side by side."""
    parts = result["parameters"]["parts"]
    size_in = (5.4 * max(len(parts), 1.3), 4.4)
    figure, axes = sheet(result, 1, len(parts), size_in=size_in)
    data = result["data"]
    for letter, part, panel in zip("ab", parts, axes[0], strict=False):
        hertz = numbers(data[f"{part}_hz"])
        panel.plot(hertz, numbers(data["ideal"][part]), ":", color=OBJECT,
                   label="direct coupling at 1 kHz (ideal)")  # fmt: skip
        for place, impedance in enumerate(result["parameters"]["impedances"]):
            panel.plot(
                hertz, numbers(data[f"b_{impedance:g}"][part]), LINES[place % 3],
                color=colour_of(place), label=f"multirate waves, b = {impedance:g} Ns/m",
            )  # fmt: skip
        panel.set_yscale("log")
        panel.set_xlim(hertz[0], hertz[-1])
        panel.set_xlabel("frequency [Hz]")
        panel.set_ylabel("|X_m / F_h| [m/N]")
        panel.set_title(f"({letter}) {part} frequencies")
        upper = panel.secondary_xaxis("top", functions=(_normalised, _hertz))
        upper.set_xlabel("normalised frequency [x π rad/sample]", fontsize=8)
        upper.tick_params(labelsize=8)
    axes[0, -1].legend(loc="best")
    if parts == ["low"]:
        axes[0, 0].set_ylim(None, 4.0 * axes[0, 0].get_ylim()[1])
    return figure


def _normalised(hertz: Any) -> Any:
    return 2.0 * hertz / TICK_HZ


def _hertz(normalised: Any) -> Any:
    return normalised * TICK_HZ / 2.0


def widths(result: Values) -> Any:
    """Draw the largest stiffness over damping, one curve per connection."""
    figure, axes = sheet(result, 1, 1, size_in=(7.0, 5.0))
    panel, data = axes[0, 0], result["data"]
    damping = numbers(data["damping"])
    for place, (name, curve) in enumerate(result["parameters"]["curves"].items()):
        if np.isnan(numbers(data[name])).all():
            continue  # no limit found anywhere: the remark says so
        direct = curve.get("controller") == "direct"
        panel.plot(
            damping, numbers(data[name]), ":" if direct else LINES[place % 2],
            color=OBJECT if direct else colour_of(place), label=curve["label"],
        )  # fmt: skip
    panel.set_xlabel("wall damping B [Ns/m]")
    panel.set_ylabel("largest wall stiffness K [N/m]")
    panel.set_xlim(damping[0], damping[-1])
    panel.set_ylim(0.0, None)
    panel.legend(loc="best")
    return figure


def contact(result: Values) -> Any:
    """Draw positions and forces of a contact."""
    figure, axes = sheet(result, 2, 1, size_in=(7.6, 6.2))
    data = {name: numbers(values) for name, values in result["data"].items()}
    above, below = axes[:, 0]
    above.axhline(0.0, color=style.LIGHT["target"], linewidth=0.8)
    for panel, unit, master, server in (
        (above, "mm", "x_m", "x_s"),
        (below, "n", "f_m", "f_s"),
    ):
        labels = (f"${master[0].upper() if unit == 'n' else 'x'}_m$",
                  f"${server[0].upper() if unit == 'n' else 'x'}_s$")  # fmt: skip
        panel.plot(data["time_s"], data[f"{server}_{unit}"], color=style.LIGHT_USERS[1],
                   label=labels[1], linewidth=1.0)  # fmt: skip
        panel.plot(data["time_s"], data[f"{master}_{unit}"], color=style.LIGHT_USERS[0],
                   label=labels[0], linewidth=1.2)  # fmt: skip
        panel.set_xlim(0.0, data["time_s"][-1])
        panel.set_xlabel("time [s]")
        panel.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    above.set_title("(a) Positions of the device $x_m$, and commanded in the VE $x_s$")
    below.set_title("(b) Forces applied to the user $F_m$, and computed in the VE $F_s$")
    above.set_ylabel("depth in the wall [mm]")
    below.set_ylabel("force [N]")
    return figure
