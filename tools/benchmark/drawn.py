# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The picture of a study: trouble and errors at every task, and the walls, on every network."""

from collections.abc import Callable, Sequence

import numpy as np

from benchmark.columns import FORCE, POSITION, Z_WIDTH, Column, Rows, troubled, value_of
from benchmark.study import Study
from pmwvc_analysis.charts.chart import Chart, Dots, Panel
from pmwvc_analysis.charts.style import user_tint

PICTURE = "benchmark"
Found = Callable[[str, Sequence[str]], Rows]  # of a method on networks
ROWS = 3  # of names below the picture
MARKS = ("ring", "cross", "plus")
WIDTH = 0.8  # of the place of a network: methods side by side
FIRST, OTHERS = 300.0, 160.0  # heights of panels: that which names them, the others


def picture(study: Study) -> Chart:
    """Return trouble and errors on every network; medians that are infinite are not drawn, small
    ones at the lower edge.
    """
    panels = [_panel(study, "failed or restless [%]", _all_tasks(study), _trouble, names=True)]
    for task in study.plan.tasks:
        for column in (POSITION, FORCE):
            panels.append(_of_column(study, f"{task}: {column.label}", column, _at(study, task)))
    if study.walled:
        panels.append(_of_column(study, Z_WIDTH.label, Z_WIDTH, study.rendered))
    caption = (
        "Share of the sessions of all tasks, and medians over the seeds of a network. A median "
        "that is infinite, as of mostly failed sessions, is not drawn. Networks with a star took "
        "part in the search."
    )
    return Chart(PICTURE, "Controllers and channels on every network", caption, panels)


def _at(study: Study, task: str) -> Found:
    return lambda method, networks: study.of(method, task, networks)


def _all_tasks(study: Study) -> Found:
    def of(method: str, networks: Sequence[str]) -> Rows:
        each = [study.of(method, task, networks) for task in study.plan.tasks]
        return [[one for row in rows for one in row] for rows in zip(*each, strict=True)]

    return of


def _trouble(rows: Rows) -> float:
    return 100.0 * troubled(rows).value


def _of_column(study: Study, label: str, column: Column, of: Found) -> Panel:
    def value(rows: Rows) -> float:
        return max(value_of(rows, column), column.least) if rows[0] else np.inf

    return _panel(study, label, of, value, log=not column.larger)


def _panel(
    study: Study, label: str, of: Found, value: Callable[[Rows], float], *, log: bool = False,
    names: bool = False,
) -> Panel:  # fmt: skip
    """Return a panel with a value of the sessions on each network, side by side by method, in the
    first panel with their ``names``.
    """
    networks = ordered(study)
    count, dots = len(study.plan.methods), []
    for index, method in enumerate(study.plan.methods):
        found = np.array([value([row]) for row in of(method, networks)])
        shown = np.isfinite(found)
        x = np.arange(len(networks)) + WIDTH * ((index + 0.5) / count - 0.5)
        name = method if names else f"_{method}"  # matplotlib leaves these out of a legend
        mark = MARKS[index % len(MARKS)]
        dots.append(Dots(name, x[shown], found[shown], user_tint(index), mark))
    return Panel(
        label,
        height=FIRST if names else OTHERS,
        dots=dots,
        x_label="",
        x_names=[_name(study, network, row) for row, network in enumerate(networks)],
        y_log=log,
        y_range=(-5.0, 105.0) if label.endswith("[%]") else None,
    )


def ordered(study: Study) -> tuple[str, ...]:
    """Return the networks in the order of the picture."""
    searched = (name for name in study.plan.networks if name in study.plan.training)
    return (*study.held_out, *searched)


def _name(study: Study, network: str, place: int) -> str:
    """Return a network's name in one of the rows, with a star where the search met it."""
    star = "*" if network in study.plan.training else ""
    return "\n" * (place % ROWS) + network + star
