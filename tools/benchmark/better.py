# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Where the strict channel is not the best: by network, task and figure, by how much, and the
reasons that other numbers of the same sessions give.
"""

import math
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
    """Return a table for each task: where on the held-out networks another method is better."""
    found = places(study, study.held_out)
    text = []
    for task in dict.fromkeys(place.task for place in found):
        of_task = [place for place in found if place.task == task]
        columns = list(dict.fromkeys(place.column for place in of_task))
        lines = [["network", *(column.label for column in columns), "reasons"]]
        for network in dict.fromkeys(place.network for place in of_task):
            here = {place.column: place for place in of_task if place.network == network}
            cells = [_cell(here[column]) if column in here else "" for column in columns]
            lines.append([network, *cells, "; ".join(_why(study, list(here.values())))])
        head, *rows = (f"| {' | '.join(cells)} |\n" for cells in lines)
        text.append(f"### {task}\n\n{head}{'|---' * len(lines[0])}|\n{''.join(rows)}")
    return "\n".join(text) or "Nowhere.\n"


def _why(study: Study, here: Sequence[Place]) -> list[str]:
    """Return the reasons of the places of a network and task, by kind, each once."""
    found: dict[str, dict[str, None]] = {}
    defaults: list[str] = []
    for place in (place for place in here if place.task != "walls"):
        of = study, place.network, place.task, place.column
        for kind, amount in reasons(*of, place.method):
            found.setdefault(kind, {})[amount] = None
        defaults += settings(*of, place.ours)
    if defaults:
        found["defaults"] = dict.fromkeys(defaults)
    return [f"{kind}: {', '.join(amounts)}" for kind, amounts in found.items()]


def _cell(place: Place) -> str:
    return f"`{place.method}` {number(place.other)} ({number(place.ours)})"


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
