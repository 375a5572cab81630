# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Figure: the benchmark's medians over networks that no search has met, a panel for each task and
figure (docs/benchmark_results.csv, written by ``make benchmark``).
"""

import csv
import math

import numpy as np

from paper.drawing import COLOURS, ROOT, Rows, panels, save

NAME = "summary"
FILE = ROOT / "docs" / "benchmark_results.csv"
SHOWN = ("position error [mm]", "force error [N]", "buzz [N]", "failed or restless [%]")
COMPARED = ("strict", "plain")  # in the table of numbers


def medians() -> dict[tuple[str, str, str], float]:
    """Return the medians of the benchmark by task, measure and method."""
    rows = csv.DictReader(FILE.read_text("utf-8").splitlines())
    return {
        (row["task"], row["measure"], row["method"]): (
            math.inf if row["median"] in ("fails", "unknown") else float(row["median"])
        )
        for row in rows
        if "task" in row
    }


def make() -> Rows:
    """Draw, and return the numbers: nothing where the benchmark has not been written."""
    found = medians()
    tasks = [task for task in dict.fromkeys(key[0] for key in found) if task != "walls"]
    methods = list(dict.fromkeys(key[2] for key in found))
    if not tasks:
        return []
    figure, axes = panels(len(SHOWN), len(tasks), 6.0, sharey="row", sharex=True)
    for row, measure in enumerate(SHOWN):
        for column, task in enumerate(tasks):
            place = axes[row * len(tasks) + column]
            for number, method in enumerate(methods):
                value = found.get((task, measure, method), math.nan)
                size, colour = (value if math.isfinite(value) else 0.0), COLOURS[number % 8]
                place.bar(number, size, color=colour)
                if math.isinf(value):
                    place.annotate("fails", (number, 0.0), rotation=90, ha="center", fontsize=6)
            place.set_xticks(np.arange(len(methods)), methods, rotation=90, fontsize=7)
            if row == 0:
                place.set_title(task)
            if column == 0:
                place.set_ylabel(measure)
    save(figure, NAME)
    numbers = [["task", *SHOWN]]
    for task in tasks:
        for method in COMPARED:
            values = [found.get((task, measure, method), math.nan) for measure in SHOWN]
            texts = ["fails" if math.isinf(value) else f"{value:.3g}" for value in values]
            numbers.append([f"{task}, {method}", *texts])
    return numbers
