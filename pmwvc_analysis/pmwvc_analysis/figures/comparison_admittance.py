# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Transmitted admittance of all sessions of a comparison in one panel, the ideal beside them."""

from collections.abc import Sequence
from typing import Any

from pmwvc_analysis.charts import style
from pmwvc_analysis.compare.feel import ideal_feel
from pmwvc_analysis.compare.measures import Entry

MOST = 8  # curves that can be told apart


def draw(entries: Sequence[Entry]) -> Any | None:
    """Draw |x/f| over frequency, lines from models and dots from chirps; None without any."""
    shown = [
        entry for entry in entries if entry.feel is not None and len(entry.feel.frequency_hz)
    ][:MOST]
    if not shown:
        return None
    figure, (axes,) = style.canvas(
        1,
        title="Transmitted admittance of the first user",
        note="lines: exact model · dots: from the chirp of the session",
        row_in=4.2,
    )
    ideal = ideal_feel(shown[0].scenario)
    if ideal.source:
        axes.plot(
            ideal.frequency_hz,
            ideal.admittance,
            color=style.OBJECT,
            ls=":",
            label="ideal: direct at every tick, no delay",
        )
    for place, entry in enumerate(shown):
        feel = entry.feel
        assert feel is not None
        dots = {"ls": "", "marker": "o", "ms": 3.0, "mfc": "none"}
        options: dict[str, Any] = dots if feel.source == "measured" else {"lw": 1.6}
        axes.plot(
            feel.frequency_hz,
            feel.admittance,
            color=style.colour(place),
            label=entry.label,
            **options,
        )
    axes.set(xscale="log", yscale="log", xlabel="frequency [Hz]", ylabel="|x / f| [m/N]")
    style.legend(axes)
    return figure
