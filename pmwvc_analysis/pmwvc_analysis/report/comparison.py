# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A comparison on disk: tables for programs, a page for people, and a folder for every session.

``comparison.json`` and ``.csv`` hold a row per session; ``comparison.html`` is self-contained, the
table first.
"""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pmwvc_analysis.arrays import write_table
from pmwvc_analysis.charts.chart import Chart
from pmwvc_analysis.compare.measures import COLUMNS, MEASURES, Compared
from pmwvc_analysis.compare.settings import parameters_of, tuning_of
from pmwvc_analysis.figures.comparison_charts import draw_all
from pmwvc_analysis.report.page import data_uri, filled
from pmwvc_core.errors import file_errors

JSON, TABLE = "comparison.json", "comparison.csv"
PAGE, TEMPLATE = "comparison.html", "comparison_template.html"


def write(
    folder: Path, title: str, entries: Sequence[Compared], about: dict[str, Any], *, figures: bool
) -> dict[str, Any]:
    """Write tables and, with ``figures``, pictures and page; return the content of
    ``comparison.json``, of which ``about`` are further keys: ``kind``; ``notes``, a list of
    sentences for the report. RecordingError where the folder cannot be written into.
    """
    result = {"title": title, **about, "sessions": [row(entry) for entry in entries]}
    with file_errors(f"write into {folder}"):
        text = json.dumps(result, indent=2, ensure_ascii=False, allow_nan=False)
        (folder / JSON).write_text(text + "\n", encoding="utf-8")
        rows = [row(entry) | entry.settings for entry in entries]
        names = dict.fromkeys(name for entry in entries for name in entry.settings)
        columns = "label", "source", *names, *MEASURES
        write_table(folder / TABLE, {each: [one.get(each) for one in rows] for each in columns})
        if figures:
            drawn = draw_all(entries, folder / "plots")
            (folder / PAGE).write_text(render(title, entries, result, drawn), encoding="utf-8")
    return result


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
        settings=[(e.label, parameters_of(e.scenario), tuning_of(e.scenario)) for e in entries],
        columns=[(name, heading, factor) for name, heading, _, factor in COLUMNS],
        figures=[(chart, data_uri(path)) for chart, path in figures],
    )


def row(entry: Compared) -> dict[str, Any]:
    """Return one session of ``comparison.json``."""
    return {
        "label": entry.label, "source": entry.traces.source, "folder": entry.folder,
        "settings": entry.settings, "parameters": parameters_of(entry.scenario),
        "tuning": tuning_of(entry.scenario), **entry.measures,
    }  # fmt: skip
