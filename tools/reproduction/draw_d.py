# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Drawing of App. D that no other appendix has."""

from typing import Any

from reproduction.drawing import OBJECT, colour_of, numbers, sheet
from reproduction.figure import Values


def condition(result: Values) -> Any:
    """Fig. 5, and beside it the velocity filter 1 - HP."""
    data, claimed = result["data"], result["numbers"]
    figure, axes = sheet(result, 1, 2, size_in=(10.4, 4.4))
    left, right = axes[0]
    angle = numbers(data["angle_over_pi"])
    for place, (name, words) in enumerate((("printed", "printed"), ("ours", "flattest, ours"))):
        label = f"α = {claimed[f'alpha_{name}']:.4f} ({words})"
        colour = colour_of(place)
        left.plot(angle, numbers(data[f"in_phase_{name}"]), color=colour, label=f"Eq. 14, {label}")
        left.plot(angle, numbers(data[f"any_environment_{name}"]), "--", color=colour,
                  label="any environment")  # fmt: skip
        right.plot(angle, numbers(data[f"velocity_gain_{name}"]), color=colour, label=label)
    left.axhline(1.0, color=OBJECT, linewidth=0.8)
    left.set_ylabel("right-hand side of the condition")
    right.set_ylabel("gain of the velocity filter |1 - H_HP|")
    for panel in (left, right):
        panel.set_xlabel("normalised frequency [x π rad/sample]")
        panel.set_xlim(0.0, 1.0)
        panel.legend(loc="best")
    return figure
