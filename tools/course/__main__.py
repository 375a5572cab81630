# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Run every session of the course and write numbers, pictures and pages: ``make course``."""

import json
from dataclasses import replace
from pathlib import Path

from course.page import watch
from course.step import Numbers, simulated
from course.watching import WATCHED
from course.written import NUMBERS, STEPS, pages
from pmwvc_analysis.charts.chart_files import write

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "course"


def main() -> None:
    """Compute and write."""
    images = FOLDER / "images"
    images.mkdir(parents=True, exist_ok=True)
    numbers: dict[str, Numbers] = {}
    for step in STEPS:
        found = {name: simulated(run) for name, run in step.runs.items()}
        numbers[step.name] = {
            name: float(f"{value:.6g}")
            for name, value in (
                step.numbers(found) | step.answers() | watch(WATCHED[step.name])[0]
            ).items()
        }
        write(replace(step.chart(found), name=step.name), images, kinds=["svg"])
        print(step.name)
    text = json.dumps(numbers, indent=1, allow_nan=False)
    (FOLDER / NUMBERS).write_text(text + "\n", "utf-8")
    for name, page in pages(numbers).items():
        (FOLDER / name).write_text(page, "utf-8")


if __name__ == "__main__":
    main()
