# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What pushes the device, by the type of its state; here given forces, whatever the device does:
ideal sources, for experiments (App. B Fig. 5 uses 1 N from each side). For a person see ``hand``.
"""

import math
from typing import NamedTuple

import numpy as np

from pmwvc_core.law.family import Family
from pmwvc_core.law.vectors import Vector, each, scaled, zero
from pmwvc_core.numeric import Array

# (s, x, xd, acts, p) -> (s, f_h [N]) over this tick; no time passes before a hand ``acts``.
hand_force = Family("hand_force")


class GivenForce(NamedTuple):
    """A force along axis 0: constant, or a sine with phase zero at the start, whose frequency may
    rise linearly, sweep after sweep, in one phase: phi(t) = 2 pi [n (f0 + f1) S/2 + f0 t +
    (f1 - f0) t^2/(2 S)], t since the start of sweep n.
    """

    ticks: int


class ForceParams(NamedTuple):
    """Force along axis 0, and how it changes."""

    force: Vector  # [N] amplitude
    swings: bool  # else it is constant
    tick_s: float
    first_hz: float  # f0
    last_hz: float  # f1
    sweep_s: float  # S


@hand_force.member(GivenForce)
def _given(
    s: GivenForce, x: Vector, xd: Vector, acts: bool, p: ForceParams
) -> tuple[GivenForce, Vector]:
    if not acts:
        return s, zero(x)
    if not p.swings:
        return s, p.force
    sweep, time_s = divmod(s.ticks * p.tick_s, p.sweep_s)
    cycles = sweep * (p.first_hz + p.last_hz) * p.sweep_s / 2.0 + time_s * (
        p.first_hz + (p.last_hz - p.first_hz) * time_s / (2.0 * p.sweep_s)
    )
    return GivenForce(s.ticks + 1), scaled(p.force, math.sin(2.0 * math.pi * cycles))


class RecordedForce(NamedTuple):
    """A recorded force, one row per tick, whatever the device does."""

    ticks: int


class RecordedParams(NamedTuple):
    """A recording of forces."""

    rows: Array  # (ticks, axes) [N]
    axes: tuple[int, ...]  # numbers of the axes: 0, 1 ...
    repeat: bool  # else there is no force after its end
    early: bool  # its time passes from the first tick, coupled or not


def recorded_params(recording: Array, axes: int, repeat: bool, early: bool) -> RecordedParams:
    """Return the parameters of a recorded force, ``(ticks, 1 or axes)`` [N]."""
    return RecordedParams(rows_of(recording, axes), tuple(range(axes)), repeat, early)


def rows_of(recording: Array, axes: int) -> Array:
    """Return the rows of a recording along all axes; a single column goes to axis 0."""
    rows = np.zeros((len(recording), axes))
    rows[:, : recording.shape[1]] = recording
    return rows


def row(rows: Array, number: int, axes: tuple[int, ...]) -> Vector:
    """Return a row of a table as a vector."""
    found: Vector = each(_element, (axes,), rows, number)
    return found


def _element(axis: int, rows: Array, number: int) -> float:
    return float(rows[number, axis])


@hand_force.member(RecordedForce)
def _recorded(
    s: RecordedForce, x: Vector, xd: Vector, acts: bool, p: RecordedParams
) -> tuple[RecordedForce, Vector]:
    if not acts and not p.early:
        return s, zero(x)
    number, after = s.ticks, RecordedForce(s.ticks + 1)
    if p.repeat:
        number = number % len(p.rows)
    return after, row(p.rows, number, p.axes) if number < len(p.rows) else zero(x)
