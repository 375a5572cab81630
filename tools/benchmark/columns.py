# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The numbers of a study that tables and picture show, and their medians with intervals."""

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from benchmark.intervals import Interval, median, ratio
from pmwvc_core.numeric import Array

Rows = Sequence[Sequence[Any]]  # networks, seeds


class Column(NamedTuple):
    """A number of each session: field, factor to the unit, heading."""

    name: str
    factor: float
    label: str
    least: float = 0.0  # differences below it, in the unit, are none
    larger: bool = False  # is better
    compared: bool = True  # method by method, network by network
    sized: bool = False  # its size is better the smaller: it may have either sign


POSITION = Column("coherency_m", 1e3, "position error [mm]", 0.05)
FORCE = Column("force_error_n", 1.0, "force error [N]", 0.01)
LAG_FREE = Column("lag_free_error_n", 1.0, "force error less lag [N]", compared=False)
CONTACT = Column("contact_n", 1.0, "contact force [N]", compared=False)
PEAK = Column("peak_n", 1.0, "peak force [N]", compared=False)
BUZZ = Column("buzz_n", 1.0, "buzz [N]", 0.005)
STEP = Column("step_n", 1.0, "step of force [N]", 0.05)
DROPOUT = Column("dropout_s", 1e3, "dropouts [ms]", 5.0)
RELEASED = Column("deficit_j", 1e3, "released [mJ]", compared=False)
FIRST, LAST = (POSITION, FORCE), (BUZZ, STEP)
OF_TASK = {
    "carry": (
        *FIRST,
        Column("path_error_m", 1e3, "cube less target [mm]", 0.5),
        Column("completion_s", 1.0, "completion time [s]", 0.05),
        *LAST,
        DROPOUT,
        LAG_FREE,
        PEAK,
        Column("grip_lost", 100.0, "grip lost [%]", compared=False),
        Column("absorbed", 100.0, "absorbed [%]", compared=False),
        RELEASED,
    ),
    "wall": (
        *FIRST,
        Column("stiffness_n_m", 1.0, "felt for 2000 [N/m]", 20.0, larger=True),
        *LAST,
        DROPOUT,
        LAG_FREE,
        CONTACT,
        PEAK,
        RELEASED,
    ),
    "tapping": (*FIRST, *LAST, LAG_FREE, CONTACT, PEAK, RELEASED),
    "free": (
        *FIRST,
        Column("mass_kg", 1.0, "mass of the link [kg]", 0.02, sized=True),
        Column("damping_n_s_m", 1.0, "damping of the link [N s/m]", 0.1, sized=True),
        *LAST,
        Column("lag_s", 1e3, "lag of the avatar [ms]", compared=False),
        RELEASED,
    ),
}
Z_WIDTH = Column("rendered", 100.0, "walls rendered [%]", 3.0, larger=True)
OF_WALLS = (
    Z_WIDTH,
    Column("rendered_passive", 100.0, "and passive [%]", larger=True),
    Column("stiffness_max_n_m", 1.0, "largest stiffness [N/m]", larger=True),
)


def failed(rows: Rows) -> Interval:
    """Return the share of sessions that failed."""
    return ratio(_array(rows, lambda one: bool(one.failure)))


def restless(rows: Rows) -> Interval:
    """Return the share of sessions that keep oscillating."""
    return ratio(_array(rows, lambda one: one.restless))


def troubled(rows: Rows) -> Interval:
    """Return the share of sessions that failed or keep oscillating."""
    return ratio(_array(rows, lambda one: bool(one.failure) or one.restless))


def median_of(rows: Rows, column: Column) -> Interval:
    """Return the median and its interval; of an even number the worse one of the two."""
    values = _array(rows, lambda one: _known(getattr(one, column.name), column))
    if not values.size:
        return Interval(math.nan, math.nan, math.nan)
    if not column.larger:
        return median(values)
    value, high, low = (-each for each in median(-values))
    return Interval(value, low, high)


def value_of(rows: Rows, column: Column) -> float:
    """Return the median in the unit of a column."""
    return column.factor * median_of(rows, column).value


def _known(value: float | None, column: Column) -> float:
    """Return a number of a session; the worst where it is not known."""
    if value is None or math.isnan(value):
        return 0.0 if column.larger else math.inf
    return abs(value) if column.sized else value


def _array(rows: Rows, of: Callable[[Any], float]) -> Array:
    return np.array([[float(of(one)) for one in row] for row in rows])


def number(value: float) -> str:
    """Return a number as tables show it."""
    if math.isnan(value):
        return "unknown"
    if abs(value) < ROUNDING:
        return "0"
    if not math.isfinite(value):
        return "fails"
    return f"{value:.3g}" if abs(value) < 1e3 else f"{float(f'{value:.3g}'):.0f}"


ROUNDING = 1e-9  # in the unit of the column: shown as 0
