# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The report of a comparison: one self-contained HTML file, the table first."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pmwvc_analysis.charts.chart import Chart
from pmwvc_analysis.compare.files import write_tables
from pmwvc_analysis.compare.measures import Compared
from pmwvc_analysis.compare.settings import parameters_of
from pmwvc_analysis.figures.comparison_charts import draw_all
from pmwvc_analysis.report.page import data_uri, filled
from pmwvc_core.errors import file_errors

PAGE, TEMPLATE = "comparison.html", "comparison_template.html"
COLUMNS = (  # measure, heading of the report and of a terminal (empty: not there), factor
    ("k_max", "largest stable stiffness [N/m]", "K max [N/m]", 1.0),
    ("k_felt", "rendered stiffness [N/m]", "rendered [N/m]", 1.0),
    ("first_peak_hz", "first resonance [Hz]", "peak [Hz]", 1.0),
    ("mass_free_kg", "mass in free space [kg]", "free [kg]", 1.0),
    ("damping_free_n_s_m", "damping in free space [N s/m]", "free [N s/m]", 1.0),
    ("coherency_rms_m", "offset of the device from its avatar, RMS [mm]", "offset [mm]", 1e3),
    ("force_error_rms_n", "force error, RMS [N]", "force err [N]", 1.0),
    ("energy_min_j", "lowest energy balance of a port [mJ]", "balance [mJ]", 1e3),
    ("force_noise_n", "force noise, RMS [mN]", "noise [mN]", 1e3),
    ("force_peak_n", "largest force [N]", "", 1.0),
    ("force_step_max_n", "largest change of force in 1 ms [N]", "step [N]", 1.0),
    ("force_least_n", "least force while pressing [N]", "", 1.0),
    ("dropout_s", "force below half of the undisturbed one [ms]", "dropout [ms]", 1e3),
    ("left_out", "packets left out by a deadband [%]", "left out [%]", 100.0),
)


def write(
    folder: Path, title: str, entries: Sequence[Compared], about: dict[str, Any], *, figures: bool
) -> dict[str, Any]:
    """Write tables, traces and, with ``figures``, pictures and ``comparison.html``; return the
    content of ``comparison.json`` (:func:`pmwvc_analysis.compare.files.write_tables`).
    """
    found = write_tables(folder, title, entries, about)
    if figures:
        with file_errors(f"write into {folder}"):
            drawn = draw_all(entries, folder / "plots")
            (folder / PAGE).write_text(render(title, entries, found, drawn), encoding="utf-8")
    return found


def render(
    title: str,
    entries: Sequence[Compared],
    about: dict[str, Any],
    figures: Sequence[tuple[Chart, Path]],
) -> str:
    """Return the report as HTML."""
    return filled(
        TEMPLATE,
        title=title,
        about=about,
        entries=entries,
        settings=[(e.label, parameters_of(e.scenario), e.tuning) for e in entries],
        columns=[(name, heading, factor) for name, heading, _, factor in COLUMNS],
        figures=[(chart, data_uri(path)) for chart, path in figures],
    )
