# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Transmitted admittance over frequency: model, ideal coupling, measurement."""

from pathlib import Path
from typing import Any

import numpy as np

from pmwvc_analysis.charts import style
from pmwvc_analysis.figures.conditions import conditions, title
from pmwvc_analysis.transparency.measured import TRUSTED, Measured
from pmwvc_analysis.transparency.transparency import Transparency
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario

LINK, IDEAL, SEEN = style.USERS[0], style.OBJECT, style.USERS[1]
MOST_DOTS = 70  # evenly spread over the logarithm of the frequency
BELOW = 0.3  # share of the smallest value shown in double logarithmic axes


def draw(found: Transparency, measured: Measured | None, scenario: Scenario, *, live: bool) -> Any:
    """Draw size and phase of x/f, and the coherence where it was measured."""
    import matplotlib

    phases = "phases of a live session" if live else "phases of the simulator"

    with matplotlib.rc_context(style.SETTINGS):
        figure, rows = style.canvas(
            2 if measured is None else 3,
            title=title(f"Transmitted admittance of {found.user}", scenario),
            note=conditions(scenario, phases, without={"seed"}),
            row_in=2.9,
        )
        size, phase = rows[:2]
        for values, label, options in (
            (found.admittance, "link, exact model", {"color": LINK}),
            (found.ideal_admittance, "ideal: direct, no delay", {"color": IDEAL, "ls": ":"}),
        ):
            size.plot(found.frequency_hz, np.abs(values), label=label, **options)
            phase.plot(found.frequency_hz, _degrees(values), label=label, **options)
        if measured is not None:
            _draw_measured(rows, measured)
        _mark(size, found)
        size.set(xscale="log", yscale="log", ylabel="|x / f| [m/N]")
        lowest = np.nanmin(np.abs(found.admittance))
        size.set_ylim(bottom=BELOW * lowest)
        phase.set_ylabel("phase [°]")
        rows[-1].set_xlabel("frequency [Hz]")
        for axes in rows:
            style.legend(axes)
    return figure


def _draw_measured(rows: list[Any], measured: Measured) -> None:
    size, phase, coherence = rows
    rows_shown = np.unique(
        np.searchsorted(
            measured.frequency_hz,
            np.geomspace(measured.frequency_hz[0], measured.frequency_hz[-1], MOST_DOTS),
        )
    )
    dots = {
        "ls": "",
        "marker": "o",
        "ms": 4.0,
        "mfc": "none",
        "color": SEEN,
        "markevery": rows_shown.tolist(),
    }
    label = f"measured ({measured.stretches} stretches)"
    size.plot(measured.frequency_hz, np.abs(measured.admittance), label=label, **dots)
    phase.plot(measured.frequency_hz, _degrees(measured.admittance), label=label, **dots)
    coherence.plot(measured.frequency_hz, measured.coherence, label="coherence", **dots)
    coherence.axhline(TRUSTED, color=style.TARGET, lw=1.0, ls="--", label="trusted above")
    coherence.set(ylim=(0.0, 1.05), ylabel="coherence")


def _mark(axes: Any, found: Transparency) -> None:
    """Mark what is felt at rest and the first peak."""
    felt = found.felt
    if felt.admittance_dc is not None and felt.k_felt is not None:
        axes.axhline(
            felt.admittance_dc, color=LINK, lw=0.8, ls="--", label=f"1 / {felt.k_felt:.4g} N/m"
        )
    if felt.first_peak_hz is not None:
        axes.axvline(
            felt.first_peak_hz,
            color=style.TARGET,
            lw=0.8,
            ls="-.",
            label=f"first peak {felt.first_peak_hz:.3g} Hz",
        )


def _degrees(values: Any) -> Array:
    """Return the phase, continued over half turns [degrees]; NaN where there are no values."""
    if not np.isfinite(values).all():
        return np.full(len(values), np.nan)
    return np.asarray(np.degrees(np.unwrap(np.angle(values))), dtype=float)


def save(figure: Any, folder: Path, name: str) -> list[Path]:
    """Write a figure as PNG and as SVG."""
    paths = [style.save(figure, folder / f"{name}.png"), folder / f"{name}.svg"]
    figure.savefig(paths[1], facecolor="white", metadata={"Date": None})
    return paths
