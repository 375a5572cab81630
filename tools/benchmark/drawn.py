# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The picture of a study: failures, errors and what is rendered, on every network."""

from collections.abc import Callable, Sequence

import numpy as np

from benchmark.columns import ERROR, ERRORS, STIFFEST, Column, Rows, failed, median_of, restless
from benchmark.study import Study
from pmwvc_analysis.charts.chart import Chart, Dots, Panel
from pmwvc_analysis.charts.colours import user_tint

PICTURE = "benchmark"
MARKS = ("ring", "cross", "plus")


def picture(study: Study) -> Chart:
    """Return failures and errors on every network; medians that are infinite are not drawn, small
    ones at the lower edge.
    """
    panels = [
        _panel(study, "failed [%]", study.of, lambda row: 100.0 * failed(row).value, share=True),
        _panel(
            study, "restless [%]", study.of, lambda row: 100.0 * restless(row).value, share=True
        ),
        *(_panel(study, column.label, study.of, _scaled(column)) for column in ERRORS),
        *(
            _panel(study, column.label, study.measured, _scaled(column))
            for column in (ERROR, STIFFEST)
        ),
    ]
    caption = "Shares of sessions, and medians over all seeds; failed sessions count as infinite."
    heading = "Controllers and channels on every network"
    return Chart(PICTURE, heading, caption, panels)


def _panel(
    study: Study,
    label: str,
    of: Callable[[str, Sequence[str]], Rows],
    value: Callable[[Rows], float],
    *,
    share: bool = False,
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
        x_label=f"number of the network; the last {len(study.plan.training)}: of the search",
        x_names=[str(number + 1) for number in range(len(networks))],
        y_log=not share,
        y_range=(-5.0, 105.0) if share else None,
    )


def ordered(study: Study) -> tuple[str, ...]:
    """Return the networks in the order of the picture."""
    searched = (name for name in study.plan.networks if name in study.plan.training)
    return (*study.held_out, *searched)


def _scaled(column: Column) -> Callable[[Rows], float]:
    return lambda rows: max(column.factor * median_of(rows, column).value, column.least)
