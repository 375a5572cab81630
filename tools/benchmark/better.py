# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Where the strict channel is not the best: by network, task and figure, by how much, and the
reasons that other numbers of the same sessions give.
"""

import csv
import io
import math
from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

from benchmark.columns import (
    OF_TASK,
    Z_WIDTH,
    Column,
    failed,
    number,
    troubled,
    value_of,
)
from benchmark.reasons import reasons, settings
from benchmark.study import OURS, Study

BETTER = 0.05  # part of the strict channel's value by which another one has to be better
TROUBLED = Column("troubled", 100.0, "failed or restless [%]")


class Place(NamedTuple):
    """A network, task and figure with the best other method and the strict channel there."""

    network: str
    task: str
    column: Column
    method: str
    other: float
    ours: float


def works(study: Study, method: str, network: str) -> bool:
    """Tell whether at every task at most half of a method's sessions fail or are restless."""
    tasks = study.plan.tasks
    return all(_value(study, method, task, network, TROUBLED) <= 50.0 for task in tasks)


def places(study: Study, networks: Sequence[str], *, everywhere: bool = False) -> list[Place]:
    """Return where another method that works is better, each with the best one; ``everywhere``:
    also of those that do not work.
    """
    found = []
    for network in networks:
        others = [name for name in study.plan.methods if name != OURS]
        others = [name for name in others if everywhere or works(study, name, network)]
        for task in study.plan.tasks:
            for column in (TROUBLED, *(each for each in OF_TASK[task] if each.compared)):
                values = {name: _value(study, name, task, network, column) for name in others}
                ours = _value(study, OURS, task, network, column)
                found += _place(values, ours, network, task, column)
        if network in study.plan.walled:
            rows = {name: study.rendered(name, [network]) for name in (*others, OURS)}
            walls = {name: value_of(each, Z_WIDTH) for name, each in rows.items()}
            found += _place(walls, walls.pop(OURS), network, "walls", Z_WIDTH)
    return found


def _place(
    values: dict[str, float], ours: float, network: str, task: str, column: Column
) -> list[Place]:
    """Return the place, if any of the others is better."""
    if not values:
        return []
    sign = -1.0 if column.larger else 1.0
    best = min(values, key=lambda name: sign * values[name])
    other = values[best]
    ahead = sign * (ours - other)
    better = math.isfinite(other) and ahead > max(BETTER * min(abs(ours), 1e300), column.least)
    return [Place(network, task, column, best, other, ours)] if better else []


def _value(study: Study, method: str, task: str, network: str, column: Column) -> float:
    rows = study.of(method, task, [network])
    if column is not TROUBLED:
        return value_of(rows, column)
    return TROUBLED.factor * troubled(rows).value


def words(study: Study) -> str:
    """Return a table: for each task and figure, on how many held-out networks which other methods
    are better, and for which reasons.
    """
    found = places(study, study.held_out)
    if not found:
        return "Nowhere.\n"
    lines = ["| task | figure | networks | best method | reasons |\n|---|---|---|---|---|\n"]
    tasks = [*study.plan.tasks, "walls"]
    figures = dict.fromkeys((place.task, place.column) for place in found)
    for task, column in sorted(figures, key=lambda figure: tasks.index(figure[0])):
        here = [place for place in found if (place.task, place.column) == (task, column)]
        methods = Counter(f"`{place.method}`" for place in here)
        kinds = Counter(kind for place in here for kind in _why(study, place))
        figure = column.label.partition(" [")[0]
        cells = (task, figure, f"{len(here)}", _times(methods), _times(kinds))
        lines.append(f"| {' | '.join(cells)} |\n")
    return "".join(lines)


def _times(found: Counter[str]) -> str:
    return ", ".join(f"{name} {times}" for name, times in found.most_common())


def listed(study: Study) -> str:
    """Return every network and figure in which another method is better, as CSV."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(["task", "network", "figure", "method", "median", OURS, "reasons"])
    for place in places(study, study.held_out):
        reasons = "; ".join(f"{kind}: {amount}" for kind, amount in _why(study, place).items())
        numbers = number(place.other), number(place.ours)
        figure = place.column.label
        writer.writerow([place.task, place.network, figure, place.method, *numbers, reasons])
    return stream.getvalue()


def _why(study: Study, place: Place) -> dict[str, str]:
    """Return the reasons of a place by kind."""
    if place.task == "walls":
        return {}
    of = study, place.network, place.task, place.column
    return dict(reasons(*of, place.method)) | settings(*of, place.ours)


def counted(study: Study) -> str:
    """Return in words how often another method is better, by task and method."""
    found = places(study, study.held_out)
    total = sum(
        1 + sum(column.compared for column in OF_TASK[task]) for task in study.plan.tasks
    ) * len(study.held_out)
    total += len(set(study.held_out) & set(study.plan.walled))
    by_method: dict[str, int] = {}
    for place in found:
        by_method[place.method] = by_method.get(place.method, 0) + 1
    each = ", ".join(f"`{n}` {k}" for n, k in sorted(by_method.items(), key=lambda p: -p[1]))
    fails = [
        name
        for name in study.held_out
        if any(failed(study.of(OURS, task, [name])).value > 0.0 for task in study.plan.tasks)
    ]
    also = places(study, study.held_out, everywhere=True)
    text = f"Another method is better in {len(found)} of {total} figures"
    text += f" ({each}). " if found else ". "
    text += (
        "A method does not count on a network where more than half of its sessions at any task "
        f"fail or are restless; with those it would be {len(also)}."
    )
    return text + (f" `{OURS}` has failed sessions on {', '.join(fails)}." if fails else "")
