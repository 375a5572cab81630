# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Both margins of a velocity filter over frequency, and what it leaves of the velocity."""

from typing import Any

from pmwvc_analysis.charts import style
from pmwvc_analysis.figures.conditions import title
from pmwvc_analysis.filters.velocity_filter import VelocityFilter
from pmwvc_core.scenario.scenario import Scenario


def draw(found: VelocityFilter, scenario: Scenario) -> Any:
    """Draw both passivity margins and the gain of the velocity over frequency."""
    import matplotlib

    own, of = found.master.velocity_filter, found.margins
    with matplotlib.rc_context(style.SETTINGS):
        figure, (conditions, gain) = style.canvas(
            2,
            title=title("Velocity filter", scenario),
            note=_note(found),
            row_in=2.9,
        )
        frequency = of["frequency_hz"]
        for values, label, colour in (
            (of["in_phase"], "in phase, |H_LP + s H_HP|²", style.USERS[0]),
            (of["any_environment"], "any environment, |H_LP| + s |H_HP|", style.USERS[1]),
        ):
            conditions.plot(frequency, values, color=colour, label=label)
        if own.kind == "equivalent":
            conditions.plot(
                frequency,
                1.0 - found.port,
                color=style.TARGET,
                ls="-.",
                label="1 less the damping at the device / b",
            )
        conditions.axhline(1.0, color=style.OBJECT, lw=0.8, ls="--", label="passive up to here")
        conditions.set(ylabel="gain", ylim=(0.0, None))
        gain.plot(frequency, found.gain, color=style.USERS[0], label="|F_m / (b ẋ)|")
        gain.set(xscale="log", ylabel="velocity in the force", ylim=(0.0, None))
        gain.set_xlabel("frequency [Hz]")
        for axes in (conditions, gain):
            style.legend(axes)
    return figure


def _note(found: VelocityFilter) -> str:
    own = found.master.velocity_filter
    where = f"α = {own.alpha:.5f}" if own.alpha is not None else f"{own.cutoff_hz:.4g} Hz"
    parts = [
        f"{own.kind}, order {own.order}, {where}, s = {own.share:g} ({found.designed})",
        f"noise × {found.noise_gain:.3g}",
        f"switching gain {found.switching_gain:.4f}",
        f"M = {found.master.rate_drop}",
    ]
    return " · ".join(parts)
