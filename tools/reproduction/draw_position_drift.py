# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Drawing and table of the drift without and with position feedback."""

from typing import Any

from reproduction.drawing import numbers, sheet
from reproduction.figure import Values

LINKS = {
    "no_loss": "no loss",
    "loss": "5 % lost, silence after 30 ms",
    "loss_patient": "5 % lost, silence after 200 ms",
}
LOOK: dict[str, dict[str, Any]] = {
    "none": {"color": "#555555"},
    "printed": {"color": "#C2410C"},
    "budgeted": {"color": "#0B4F79", "linewidth": 2.0},
    "integral": {"color": "#E69F00", "linestyle": "--"},
    "stored": {"color": "#15803D", "linewidth": 2.0},
}


def drift(result: Values) -> Any:
    """One panel a link: how much closer than their avatars the two devices are."""
    figure, axes = sheet(result, 1, 3, size_in=(11.0, 4.4))
    for panel, link in zip(axes[0], result["parameters"]["links"], strict=True):
        for feedback in result["parameters"]["feedbacks"]:
            curve = result["data"][f"{link}/{feedback}"]
            panel.plot(
                numbers(curve["time_s"]),
                numbers(curve["apart_mm"]),
                label=feedback,
                **{"linewidth": 1.2, **LOOK[feedback]},
            )
        panel.set_title(LINKS[link])
        panel.set_xlabel("time [s]")
        panel.set_ylabel("devices closer than avatars [mm]")
    axes[0][0].legend()
    return figure


def table(result: Values) -> list[str]:
    """Return the lines of the table in Markdown."""
    found, given = result["numbers"], result["parameters"]
    lines = [
        "| link, 16 ms each way | feedback | RMS | at the end | force at the end "
        "| energy spent | minimum balance |",
        "|---|---|---|---|---|---|---|",
    ]
    for link in given["links"]:
        for feedback in given["feedbacks"]:
            of = {
                name: found[f"{name}_{link}_{feedback}"]
                for name in ("rms_mm", "end_mm", "force_n", "spent_mj", "least_balance_mj")
            }
            lines.append(
                f"| {LINKS[link]} | {feedback} | {of['rms_mm']:.2f} mm | {of['end_mm']:.2f} mm "
                f"| {of['force_n']:.2f} N | {of['spent_mj']:.2f} mJ "
                f"| {of['least_balance_mj']:.3f} mJ |"
            )
    return lines
