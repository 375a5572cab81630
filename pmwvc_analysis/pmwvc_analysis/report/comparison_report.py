# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The report of a comparison: one self-contained HTML file, the table first."""

from collections.abc import Sequence
from typing import Any

from pmwvc_analysis.compare.measures import Entry
from pmwvc_analysis.compare.settings import parameters_of, tuning_of
from pmwvc_analysis.figures.figures import Picture
from pmwvc_analysis.report.page import data_uri, filled

TEMPLATE = "comparison_template.html"
COLUMNS = (  # measure, heading, factor
    ("k_max", "largest stable stiffness [N/m]", 1.0),
    ("k_felt", "rendered stiffness [N/m]", 1.0),
    ("first_peak_hz", "first resonance [Hz]", 1.0),
    ("mass_free_kg", "mass in free space [kg]", 1.0),
    ("damping_free_n_s_m", "damping in free space [N s/m]", 1.0),
    ("coherency_rms_m", "offset of the device from its avatar, RMS [mm]", 1e3),
    ("force_error_rms_n", "force error, RMS [N]", 1.0),
    ("energy_min_j", "lowest energy balance of a port [mJ]", 1e3),
    ("force_noise_n", "force noise, RMS [mN]", 1e3),
    ("force_peak_n", "largest force [N]", 1.0),
)


def render(
    title: str, entries: Sequence[Entry], about: dict[str, Any], pictures: Sequence[Picture]
) -> str:
    """Return the report as HTML."""
    return filled(
        TEMPLATE,
        title=title,
        kind=about.get("kind", "comparison"),
        lead=about.get("lead", ""),
        conclusion=about.get("conclusion", []),
        notes=about.get("notes", []),
        differences=about.get("differences", []),
        changes=about.get("changes", {}),
        entries=entries,
        settings=[(e.label, parameters_of(e.scenario), tuning_of(e.scenario)) for e in entries],
        columns=COLUMNS,
        pictures=[(picture, data_uri(picture.path)) for picture in pictures],
    )
