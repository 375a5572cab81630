# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The results of a study as a table, a picture, and a file with every session."""

import csv
import io
import math
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmark.intervals import Interval, median, ratio
from benchmark.study import Study
from benchmark.trial import Outcome
from pmwvc_analysis.charts import chart_png
from pmwvc_analysis.charts.chart import Chart, Dots, Panel
from pmwvc_analysis.charts.colours import user_tint
from pmwvc_core.numeric import Array
from pmwvc_core.plural import count

TABLE, PICTURE, SESSIONS = "table.md", "benchmark", "sessions.csv"
Rows = list[list[Outcome]]  # networks, seeds
MARKS = ("ring", "cross", "plus")
ERRORS = (  # field, factor to the unit, label, least value drawn
    ("coherency_m", 1e3, "device less avatar [mm]", 0.1),
    ("force_error_n", 1.0, "force error [N]", 0.01),
    ("path_error_m", 1e3, "cube less target [mm]", 1.0),
)


def write(study: Study, folder: Path) -> None:
    """Write table, picture and sessions into a folder, made if missing."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / TABLE).write_text(table(study), "utf-8")
    (folder / SESSIONS).write_text(sessions(study), "utf-8")
    chart_png.write(picture(study), folder)


def table(study: Study) -> str:
    """Return the table over the held-out networks, what was run, and the settings chosen."""
    plan = study.plan
    head = [
        "method",
        "failed",
        "restless",
        "not passive",
        *(label for _, _, label, _ in ERRORS),
        "failures",
    ]
    lines = [_row(head), _row(["---"] * len(head))]
    for method in plan.methods:
        outcomes = study.of(method, study.held_out)
        flat = [outcome for row in outcomes for outcome in row]
        cells = [
            _cell(_failed(outcomes), 100.0, " %"),
            _cell(_restless(outcomes), 100.0, " %"),
            f"{sum(one.passive is False for one in flat)} of {len(flat)}",
            *(_cell(_error(outcomes, name), factor, "") for name, factor, *_ in ERRORS),
        ]
        kinds = Counter(one.failure for one in flat if one.failure).most_common()
        cells.append(", ".join(f"{number} {kind}" for kind, number in kinds) or "-")
        lines.append(_row([f"`{method}`", *cells]))
    sizes = (
        f"Seed {study.seed}. Search: {plan.candidates} settings for each method on "
        f"{', '.join(plan.training)}, {count(plan.training_seeds, 'seed')} each. Judged: "
        f"{len(study.held_out)} other networks, {plan.seeds} other seeds each, "
        f"{plan.duration_s:g} s a session; medians, in brackets 95 % intervals (bootstrap over "
        "networks and seeds); a session that failed counts as an infinite error."
    )
    chosen = [f"- `{name}`: `{' '.join(each)}`" for name, each in study.chosen.items()]
    numbered = (f"{number} {name}" for number, name in enumerate(_ordered(study), start=1))
    networks = f"Networks in the picture: {', '.join(numbered)}."
    return "\n".join(
        [*lines, "", sizes, "", networks, "", "Settings that the search chose:", "", *chosen, ""]
    )


def sessions(study: Study) -> str:
    """Return every session that judges, as CSV: all that is needed to run it again."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    names = ("failure", "restless", "passive", "energy_min_j", *(name for name, *_ in ERRORS))
    writer.writerow(["method", "network", "held_out", "seed", "settings", *names])
    for trial, outcome in study.judged.items():
        held_out = trial.network in study.held_out
        row = [trial.method, trial.network, held_out, trial.seed, " ".join(trial.settings)]
        writer.writerow([*row, *(_text(getattr(outcome, name)) for name in names)])
    return stream.getvalue()


def picture(study: Study) -> Chart:
    """Return failures and errors on every network; medians that are infinite are not drawn, small
    ones at the lower edge.
    """
    failed = _panel(study, "failed [%]", lambda row: 100.0 * _failed(row).value, share=True)
    restless = _panel(study, "restless [%]", lambda row: 100.0 * _restless(row).value, share=True)
    errors = [
        _panel(study, label, _scaled(name, factor, least)) for name, factor, label, least in ERRORS
    ]
    caption = "Shares of sessions, and medians over all seeds; failed sessions count as infinite."
    heading = "Controllers and channels on every network"
    return Chart(PICTURE, heading, caption, [failed, restless, *errors])


def _panel(
    study: Study, label: str, value: Callable[[Rows], float], *, share: bool = False
) -> Panel:
    """Return a panel with a value of the sessions on each network, side by side by method."""
    networks = _ordered(study)
    places = np.arange(len(networks)) - 0.06 * (len(study.plan.methods) - 1)
    dots = []
    for index, method in enumerate(study.plan.methods):
        found = np.array([value([row]) for row in study.of(method, networks)])
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


def _ordered(study: Study) -> tuple[str, ...]:
    """Return the networks in the order of the picture."""
    searched = (name for name in study.plan.networks if name in study.plan.training)
    return (*study.held_out, *searched)


def _failed(rows: Rows) -> Interval:
    return ratio(_array(rows, lambda one: bool(one.failure)))


def _restless(rows: Rows) -> Interval:
    return ratio(_array(rows, lambda one: one.restless))


def _error(rows: Rows, name: str) -> Interval:
    return median(_array(rows, lambda one: getattr(one, name)))


def _scaled(name: str, factor: float, least: float) -> Callable[[Rows], float]:
    return lambda rows: max(factor * _error(rows, name).value, least)


def _array(rows: Rows, of: Callable[[Outcome], float]) -> Array:
    return np.array([[float(of(one)) for one in row] for row in rows])


def _cell(found: Interval, factor: float, unit: str) -> str:
    value, low, high = (_number(each * factor) for each in found)
    return f"{value}{unit} ({low} to {high})"


def _number(value: float) -> str:
    return f"{value:.3g}" if math.isfinite(value) else "fails"


def _text(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    return "" if value is None else str(value)


def _row(cells: list[str]) -> str:
    return f"| {' | '.join(cells)} |"
