# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Figures on disk: PNG for slides and documents, SVG beside it."""

from pathlib import Path

from pmwvc_analysis.charts import chart_png
from pmwvc_analysis.charts.chart import Chart, Span
from pmwvc_analysis.charts.chart_svg import file_svg


def write(chart: Chart, folder: Path, span: Span | None = None) -> list[Path]:
    """Write a figure as ``NAME.png`` and ``NAME.svg``; return both.

    Parameters
    ----------
    span
        Range of the time axis [s]; that of the curves by default.
    """
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / f"{chart.name}.{kind}" for kind in ("png", "svg")]
    chart_png.write(chart, paths[0], span)
    paths[1].write_text(file_svg(chart, span), encoding="utf-8")
    return paths
