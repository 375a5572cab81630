# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Drawings of App. E that no other appendix has."""

from typing import Any

from reproduction.drawing import LINES, OBJECT, colour_of, numbers, sheet
from reproduction.figure import Values

IDEAL = "direct coupling at 1 kHz (ideal)"


def limits(result: Values) -> Any:
    """Fig. 5: the largest K_VE over K_LM, one curve per gain."""
    figure, axes = sheet(result, 1, 1, size_in=(7.0, 5.0))
    panel, data = axes[0, 0], result["data"]
    local = numbers(data["local_stiffness"])
    for place, gain in enumerate(result["parameters"]["gains"]):
        panel.plot(
            local, numbers(data[f"gain_{gain:g}"]), LINES[place % 4],
            color=colour_of(place), label=f"filter bank, $K_p$ = {gain:g} √W/m",
        )  # fmt: skip
    plain = result["numbers"]["plain"]
    if plain is not None:
        panel.axhline(plain, color=OBJECT, ls=":", label="multirate waves alone")
    panel.set_xlabel("stiffness of the local model $K_{LM}$ [N/m]")
    panel.set_ylabel("largest stiffness of the environment $K_{VE}$ [N/m]")
    panel.set_xlim(local[0], local[-1])
    panel.set_ylim(0.0, None)
    panel.legend(loc="best")
    return figure


def admittances(result: Values) -> Any:
    """Fig. 6: low and high frequencies side by side."""
    figure, axes = sheet(result, 1, 2, size_in=(11.0, 4.6))
    data = result["data"]
    for letter, part, panel in zip("ab", ("low", "high"), axes[0], strict=True):
        hertz = numbers(data[f"{part}_hz"])
        panel.plot(hertz, numbers(data["ideal"][part]), ":", color=OBJECT, label=IDEAL)
        for place, (name, curve) in enumerate(result["parameters"]["curves"].items()):
            panel.plot(
                hertz, numbers(data[name][part]), LINES[place % 4],
                color=colour_of(place), label=curve["label"],
            )  # fmt: skip
        panel.set_yscale("log")
        panel.set_xlim(hertz[0], hertz[-1])
        panel.set_xlabel("frequency [Hz]")
        panel.set_ylabel("|X_m / F_h| [m/N]")
        panel.set_title(f"({letter}) {part} frequencies")
    axes[0, 1].legend(loc="best", fontsize=8)
    return figure


def measured(result: Values) -> Any:
    """Fig. 7: admittances from sweeps."""
    figure, axes = sheet(result, 1, 1, size_in=(7.6, 5.0))
    panel, data = axes[0, 0], result["data"]
    labels = {name: curve["label"] for name, curve in result["parameters"]["curves"].items()}
    for place, (name, label) in enumerate({**labels, "ideal": IDEAL}.items()):
        ideal = name == "ideal"
        panel.plot(
            numbers(data[name]["hz"]), numbers(data[name]["size"]), ":" if ideal else "-",
            color=OBJECT if ideal else colour_of(place), label=label, linewidth=1.3,
        )  # fmt: skip
    panel.set_yscale("log")
    panel.set_xlim(0.0, 50.0)
    panel.set_xlabel("frequency [Hz]")
    panel.set_ylabel("|X_m / F_h| [m/N]")
    panel.legend(loc="best")
    return figure


def impedances(result: Values) -> Any:
    """Fig. 8: force over position."""
    figure, axes = sheet(result, 1, 1, size_in=(7.6, 5.0))
    panel, data = axes[0, 0], result["data"]
    hertz = numbers(data["hz"])
    labels = {name: curve["label"] for name, curve in result["parameters"]["curves"].items()}
    for place, (name, label) in enumerate({**labels, "ideal": IDEAL}.items()):
        ideal = name == "ideal"
        panel.plot(
            hertz, numbers(data[name]), ":" if ideal else LINES[place % 4],
            color=OBJECT if ideal else colour_of(place), label=label,
        )  # fmt: skip
    panel.set_yscale("log")
    panel.set_xlim(hertz[0], hertz[-1])
    panel.set_xlabel("frequency [Hz]")
    panel.set_ylabel("|F_m / X_m| [N/m]")
    panel.legend(loc="best")
    return figure
