# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The picture of a study: failures, errors and what is rendered, on every network."""

from collections.abc import Callable, Sequence

import numpy as np

from benchmark.columns import (
    COMPLETION,
    ERROR,
    ERRORS,
    Z_WIDTH,
    Column,
    Rows,
    failed,
    median_of,
    restless,
)
from benchmark.study import Study
from pmwvc_analysis.charts.chart import Chart, Dots, Panel
from pmwvc_analysis.charts.style import user_tint

PICTURE = "benchmark"
Found = Callable[[str, Sequence[str]], Rows]  # of a method on networks
ROWS = 3  # of names below the picture
MARKS = ("ring", "cross", "plus")


def picture(study: Study) -> Chart:
    """Return failures and errors on every network; medians that are infinite are not drawn, small
    ones at the lower edge.
    """
    probed = (ERROR, Z_WIDTH, COMPLETION) if study.probed else ()
    panels = [
        _panel(study, "failed [%]", study.of, lambda rows: 100.0 * failed(rows).value),
        _panel(study, "restless [%]", study.of, lambda rows: 100.0 * restless(rows).value),
        *(_of_column(study, column, study.of) for column in ERRORS),
        *(_of_column(study, column, study.measured) for column in probed),
    ]
    caption = (
        "Shares of sessions and walls, and medians over the seeds of a network. A median that is "
        "infinite, as of mostly failed sessions, is not drawn. Networks with a star took part in "
        "the search."
    )
    heading = "Controllers and channels on every network"
    return Chart(PICTURE, heading, caption, panels)


def _of_column(study: Study, column: Column, of: Found) -> Panel:
    def value(rows: Rows) -> float:
        return max(column.factor * median_of(rows, column).value, column.least)

    return _panel(study, column.label, of, value, log=column.least > 0.0)


def _panel(
    study: Study, label: str, of: Found, value: Callable[[Rows], float], *, log: bool = False
) -> Panel:
    """Return a panel with a value of the sessions on each network, side by side by method."""
    networks = ordered(study)
    places = np.arange(len(networks)) - 0.06 * (len(study.plan.methods) - 1)
    dots = []
    for index, method in enumerate(study.plan.methods):
        found = np.array([value([row]) for row in of(method, networks)])
        shown = np.isfinite(found)
        x, y = (places + 0.12 * index)[shown], found[shown]
        dots.append(Dots(method, x, y, user_tint(index), MARKS[index % len(MARKS)]))
    return Panel(
        label,
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
