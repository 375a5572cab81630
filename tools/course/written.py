# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The pages of the course, from their templates, the runs and the committed numbers.

``docs/course/numbers.json`` is what ``make course`` computed; tests compute it again. Pages hold
no number or command of their own: templates take all of them from there.
"""

import json
from pathlib import Path

import jinja2

from course.first_half import STEPS as FIRST
from course.second_half import STEPS as SECOND
from course.step import Numbers
from course.watching import WATCHED

STEPS = (*FIRST, *SECOND)
TEMPLATES = Path(__file__).resolve().parent / "pages"
NUMBERS = "numbers.json"
GENERATED = "<!-- written by make course -->\n"


def pages(numbers: dict[str, Numbers]) -> dict[str, str]:
    """Return every page by file name."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES),
        undefined=jinja2.StrictUndefined,
        keep_trailing_newline=True,
        autoescape=False,
    )
    environment.filters |= {"f": _fixed, "neg": lambda value: -value}
    found = {"README.md": environment.get_template("README.md").render(steps=STEPS)}
    for index, step in enumerate(STEPS):
        values = numbers[step.name]
        body = environment.get_template(f"{step.name}.md").render(
            runs=step.runs, asked=step.questions, page=WATCHED[step.name], n=values, **values
        )
        after = ["Back to the [overview](README.md)."]
        if index + 1 < len(STEPS):
            after.insert(0, f"Next: [{STEPS[index + 1].title}]({STEPS[index + 1].name}.md).")
        head = f"# {index + 1}. {step.title}\n\n"
        found[f"{step.name}.md"] = f"{GENERATED}{head}{body}\n{' '.join(after)}\n"
    found["README.md"] = GENERATED + found["README.md"]
    return found


def read(folder: Path) -> dict[str, Numbers]:
    """Return the committed numbers of every step."""
    text = (folder / NUMBERS).read_text("utf-8")
    found: dict[str, Numbers] = json.loads(text)
    return found


def _fixed(value: float, digits: int) -> str:
    """Return a number with a fixed number of digits, never minus zero."""
    return f"{round(value, digits) + 0.0:.{digits}f}"
