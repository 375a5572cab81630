# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Drawings of App. A that no other appendix has."""

from typing import Any

import numpy as np

from pmwvc_analysis.charts import style
from reproduction.drawing import LINES, OBJECT, colour_of, numbers, sheet
from reproduction.figure import Values

HIGHEST_HZ = 600.0
NAMES = {"one_step_delay": "one step of computational delay", "unwrapped": "loop solved"}


def cut_offs(result: Values) -> Any:
    """Fig. 3: cut-off over M; the passive bound dotted."""
    given, data = result["parameters"], result["data"]
    figure, axes = sheet(result, 1, 2, size_in=(10.4, 4.8))
    m = numbers(data["rate_drop"])
    for letter, coupling, panel in zip("ab", given["couplings"], axes[0], strict=True):
        for place, stiffness in enumerate(given["stiffnesses"]):
            row = numbers(data[f"{coupling}/{stiffness:g}"])
            panel.plot(
                m, np.where(np.isnan(row), 2.0 * HIGHEST_HZ, row), LINES[place % 3], marker="o",
                markersize=3, color=colour_of(place), label=f"K = {stiffness:g} N/m",
            )  # fmt: skip
        panel.plot(m, numbers(data["passive_hz"]), ":", color=OBJECT,
                   label="passive: half the update rate", linewidth=2.0)  # fmt: skip
        panel.set_xlim(1, 10)
        panel.set_ylim(0, HIGHEST_HZ)
        panel.set_xlabel("rate drop M")
        panel.set_ylabel("cut-off $λ_c$ [Hz]")
        panel.set_title(f"({letter}) {NAMES[coupling]}")
    axes[0, 1].legend(loc="upper right")
    return figure


def energies(result: Values) -> Any:
    """Fig. 8: final dotted, minimum solid."""
    data = result["data"]
    figure, axes = sheet(result, 1, 1, size_in=(7.0, 4.6))
    panel, cut_off = axes[0, 0], numbers(data["cut_off_hz"])
    panel.plot(cut_off, numbers(data["minimum_j"]), "-o", color=style.LIGHT_USERS[0],
               label="$ΔE_{min}$")  # fmt: skip
    panel.plot(cut_off, numbers(data["final_j"]), ":s", color=style.LIGHT_USERS[1],
               label="$ΔE_{final}$")  # fmt: skip
    panel.axhline(0.0, color=style.LIGHT["target"], linewidth=0.8)
    panel.set_xlabel("cut-off $λ_c$ [Hz]")
    panel.set_ylabel("energy [J]")
    panel.set_xticks(cut_off)
    panel.legend(loc="best")
    return figure
