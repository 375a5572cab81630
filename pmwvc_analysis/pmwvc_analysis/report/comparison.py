# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A comparison on disk: tables for programs, traces for other tools, a page for people.

``comparison.json`` and ``.csv`` hold a row per session, ``comparison.npz`` and ``.mat`` the traces
of all of them (``s1_user1_x_m``, ``s1_server_x_o``...); ``comparison.html`` is self-contained, the
table first.
"""

import csv
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pmwvc_analysis.arrays import write_arrays
from pmwvc_analysis.charts.chart import Chart
from pmwvc_analysis.compare.conclusion import conclusion
from pmwvc_analysis.compare.measures import COLUMNS, MEASURES, Compared
from pmwvc_analysis.compare.settings import parameters_of
from pmwvc_analysis.figures.comparison_charts import draw_all
from pmwvc_analysis.report.page import data_uri, filled
from pmwvc_core.errors import file_errors
from pmwvc_core.numeric import Array

JSON, TABLE = "comparison.json", "comparison.csv"
PAGE, TEMPLATE = "comparison.html", "comparison_template.html"
OF_USER = ("time_s", "x_m", "xd_m", "f_h", "f_m", "f_applied")
OF_SERVER = ("time_s", "x_o", "xd_o", "target")


def write(
    folder: Path, title: str, entries: Sequence[Compared], about: dict[str, Any], *, figures: bool
) -> dict[str, Any]:
    """Write tables, traces and, with ``figures``, pictures and page; return the content of
    ``comparison.json``, of which ``about`` are further keys: ``kind``; ``notes``, a list of
    sentences for the report. RecordingError where the folder cannot be written into.
    """
    about = {**about, "conclusion": conclusion(entries) if about["kind"] == "comparison" else []}
    result = {"title": title, **about, "sessions": [row(entry) for entry in entries]}
    with file_errors(f"write into {folder}"):
        text = json.dumps(result, indent=2, ensure_ascii=False, allow_nan=False)
        (folder / JSON).write_text(text + "\n", encoding="utf-8")
        _write_table(folder / TABLE, entries)
        _write_arrays(folder, entries)
        if figures:
            drawn = draw_all(entries, folder / "plots")
            (folder / PAGE).write_text(render(title, entries, result, drawn), encoding="utf-8")
    return result


def render(
    title: str, entries: Sequence[Compared], about: dict[str, Any],
    figures: Sequence[tuple[Chart, Path]],
) -> str:  # fmt: skip
    """Return the report as HTML."""
    return filled(
        TEMPLATE, title=title, about=about, entries=entries,
        settings=[(e.label, parameters_of(e.scenario), e.tuning) for e in entries],
        columns=[(name, heading, factor) for name, heading, _, factor in COLUMNS],
        figures=[(chart, data_uri(path)) for chart, path in figures],
    )  # fmt: skip


def row(entry: Compared) -> dict[str, Any]:
    """Return one session of ``comparison.json``."""
    return {
        "label": entry.label,
        "source": entry.traces.source,
        "folder": entry.folder,
        "settings": entry.settings,
        "parameters": parameters_of(entry.scenario),
        "tuning": entry.tuning,
        **entry.measures,
    }


def _write_table(path: Path, entries: Sequence[Compared]) -> None:
    names = list(dict.fromkeys(name for entry in entries for name in entry.settings))
    columns = ["label", "source", *names, *MEASURES]
    with path.open("w", newline="", encoding="utf-8") as stream:
        table = csv.DictWriter(stream, columns, extrasaction="ignore")
        table.writeheader()
        table.writerows(row(entry) | entry.settings for entry in entries)


def _write_arrays(folder: Path, entries: Sequence[Compared]) -> None:
    arrays: dict[str, Array] = {}
    for number, entry in enumerate(entries, start=1):
        for user in entry.traces.users:
            arrays |= {f"s{number}_{user.name}_{name}": getattr(user, name) for name in OF_USER}
        if (server := entry.traces.server) is None:
            continue
        arrays |= {f"s{number}_server_{name}": getattr(server, name) for name in OF_SERVER}
        for index, name in enumerate(server.users):
            arrays[f"s{number}_{name}_x_s"] = server.x_s[index]
            arrays[f"s{number}_{name}_f_s"] = server.f_s[index]
    write_arrays(folder, "comparison", arrays)
