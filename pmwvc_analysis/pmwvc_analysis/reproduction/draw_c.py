# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Drawing of App. C."""

from typing import Any

from pmwvc_analysis.reproduction.draw_single import heading
from pmwvc_analysis.reproduction.drawing import EDGE, REGION, numbers, sheet
from pmwvc_analysis.reproduction.figure import Values

CASES = {"unwrapped": "1) loop unwrapped", "one_step_delay": "2) one step of delay"}
WHOSE = {"printed": "as printed", "loop": "consistent diagram"}


def regions(result: Values) -> Any:
    """Fig. 3: alpha over beta; printed above, ours below."""
    rows = result["parameters"]["rows"]
    figure, axes = sheet(
        len(rows), 2, title=heading(result), remark=result["remark"], size_in=(8.6, 10.0)
    )
    for row, line in zip(rows, axes, strict=True):
        for (case, words), panel in zip(CASES.items(), line, strict=True):
            name = f"{row['polynomial']}_sigma_{row['sigma']:g}_{case}"
            found = result["data"][name]
            alpha, beta = numbers(found["alpha"]), numbers(found["beta"])
            stable = numbers(found["stable"])
            if stable.any():
                panel.contourf(beta, alpha, stable.T, levels=[0.5, 1.5], colors=[REGION])
                panel.contour(beta, alpha, stable.T, levels=[0.5], colors=[EDGE], linewidths=1.2)
            else:
                panel.text(0.5, 0.5, "nothing is stable", ha="center", transform=panel.transAxes)
            panel.set_xlim(0.0, beta[-1])
            panel.set_ylim(0.0, alpha[-1])
            panel.set_xlabel("β = b T/m")
            panel.set_ylabel("α = K T²/m")
            panel.set_title(f"{words}, {WHOSE[row['polynomial']]}, σ = {row['sigma']:g}", size=10)
    return figure
