# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The networks on which another method is better than the strict channel, in words."""

import math
from collections.abc import Callable
from typing import NamedTuple

from benchmark.columns import (
    COMPLETION,
    ERROR,
    ERRORS,
    PEAK,
    STEP,
    Z_WIDTH,
    Column,
    failed,
    median_of,
)
from benchmark.study import Study

OURS = "strict"
BETTER = 0.05  # part of the strict channel's value by which another one has to be better
Value = Callable[[Study, str, str], float]  # of a method on a network


class Measure(NamedTuple):
    """A measure that is compared network by network."""

    label: str
    value: Value
    larger: bool = False  # is better


class Place(NamedTuple):
    """A network with the values of another method and of the strict channel there."""

    network: str
    other: float
    ours: float


def _median(column: Column, *, probed: bool = False) -> Measure:
    def value(study: Study, method: str, network: str) -> float:
        rows = (study.measured if probed else study.of)(method, [network])
        return column.factor * median_of(rows, column).value if rows[0] else math.nan

    return Measure(column.label, value, column.larger)


def _troubled(study: Study, method: str, network: str) -> float:
    (row,) = study.of(method, [network])
    return 100.0 * sum(bool(one.failure) or one.restless for one in row) / len(row)


MEASURES = (
    Measure("failed [%]", lambda study, *of: 100.0 * failed(study.of(of[0], of[1:])).value),
    Measure("failed or restless [%]", _troubled),
    *(_median(column) for column in (*ERRORS, PEAK, STEP)),
    *(_median(column, probed=True) for column in (ERROR, Z_WIDTH, COMPLETION)),
)


def words(study: Study) -> str:
    """Return a table: the measures in which each other method is better by 5 % or more, on how
    many of the held-out networks, and the clearest of them.
    """
    others = [name for name in study.plan.methods if name != OURS]
    lines = [["better in", *(f"`{name}`" for name in others)], ["---"] * (len(others) + 1)]
    for measure in MEASURES:
        cells = [_cell(better(study, name, measure)) for name in others]
        if any(cell != "-" for cell in cells):
            lines.append([measure.label, *cells])
    return "".join(f"| {' | '.join(cells)} |\n" for cells in lines)


def better(study: Study, other: str, measure: Measure) -> list[Place]:
    """Return the held-out networks on which another method is better, the clearest first."""
    places = [
        Place(net, measure.value(study, other, net), measure.value(study, OURS, net))
        for net in study.held_out
    ]
    sign = -1.0 if measure.larger else 1.0
    found = [
        place
        for place in places
        if math.isfinite(place.other)
        and sign * (place.ours - place.other) > BETTER * min(abs(place.ours), 1e300)
    ]
    return sorted(found, key=lambda place: sign * _ratio(place))


def _ratio(place: Place) -> float:
    return place.other / place.ours if place.ours else math.inf


def _cell(places: list[Place]) -> str:
    if not places:
        return "-"
    most = places[0]
    return f"{len(places)}: `{most.network}` {_number(most.other)} ({_number(most.ours)})"


def _number(value: float) -> str:
    return f"{round(value, 9):.3g}" if math.isfinite(value) else "fails"
