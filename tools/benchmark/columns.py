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
    """A number of each session or probe: field, factor to the unit, heading."""

    name: str
    factor: float
    label: str
    least: float = 0.0  # value drawn, on a logarithmic axis where it is above zero
    larger: bool = False  # is better
    asked: bool = False  # networks on which it is known for no method are left out


ERRORS = (
    Column("coherency_m", 1e3, "device less avatar [mm]", 0.1),
    Column("force_error_n", 1.0, "force error [N]", 0.01),
    Column("path_error_m", 1e3, "cube less target [mm]", 1.0),
)
PEAK = Column("peak_n", 1.0, "peak force [N]")
STEP = Column("step_n", 1.0, "step of force [N]")
OF_SESSION = (
    Column("deficit_j", 1e3, "released [mJ]"),
    Column("lag_free_error_n", 1.0, "force error less lag [N]"),
    Column("apart_max_m", 1e3, "largest distance [mm]"),
    PEAK,
    STEP,
    Column("least_n", 1.0, "least force [N]"),
    Column("dropout_s", 1e3, "dropouts [ms]"),
    Column("buzz_n", 1.0, "buzz [N]"),
    Column("squeeze_n", 1.0, "mean grip force [N]"),
    Column("grip_lost", 100.0, "grip lost [%]"),
    Column("kept_back", 100.0, "absorbed [%]"),
    Column("asymmetry", 100.0, "work asymmetry [%]"),
)
Z_WIDTH = Column("z_width", 100.0, "walls rendered [%]", larger=True)
COMPLETION = Column("completion_s", 1.0, "completion time [s]")
STIFFEST = Column("stiffness_max_n_m", 1.0, "largest stiffness [N/m]", larger=True)
ERROR = Column("transparency", 1.0, "impedance error [decades]", 0.01)
OF_PROBE = (
    Z_WIDTH,
    Column("z_width_passive", 100.0, "and passive [%]", larger=True),
    STIFFEST,
    Column("stiffness_n_m", 1.0, "rendered for 500 [N/m]", larger=True),
    Column("mass_kg", 1.0, "mass [kg]", asked=True),
    Column("damping_n_s_m", 1.0, "damping [N s/m]", asked=True),
    ERROR,
    Column("drift_m_s", 6e4, "drift [mm/min]"),
    Column("held_apart_m", 1e3, "offset after the hold [mm]"),
    COMPLETION,
)


def failed(rows: Rows) -> Interval:
    """Return the share of sessions that failed."""
    return ratio(_array(rows, lambda one: bool(one.failure)))


def restless(rows: Rows) -> Interval:
    """Return the share of sessions that keep oscillating."""
    return ratio(_array(rows, lambda one: one.restless))


def median_of(rows: Rows, column: Column) -> Interval:
    """Return the median and its interval; of an even number the worse one of the two."""
    values = _array(rows, lambda one: getattr(one, column.name))
    if not values.size:
        return Interval(math.nan, math.nan, math.nan)
    if not column.larger:
        return median(values)
    value, high, low = (-each for each in median(-values))
    return Interval(value, low, high)


def _array(rows: Rows, of: Callable[[Any], float]) -> Array:
    return np.array([[float(of(one)) for one in row] for row in rows])
