# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The implicit step where a wave impedance couples the axes: one vector equation for the object.

With r(v) the force that is missing at a mean velocity v of the object, dr/dv is symmetric and at
least 2 m_o/h + b_o (the contacts' slopes are symmetric and not negative): r is the gradient of a
convex function, so it has one root, and |r| falls along Newton's direction. A step that does not
make it smaller is halved. With two-sided contacts alone the first step is the closed form.
"""

import sys
from collections.abc import Callable

import numpy as np

from pmwvc_core.numeric import Array, Value
from pmwvc_core.server.contacts import Answer
from pmwvc_core.server.coupled_axes import CoupledAnswer
from pmwvc_core.server.cube import Body
from pmwvc_core.wave.impedance import times

_ROUNDING = 8.0 * sys.float_info.epsilon
_LIMIT = 90


def solve_coupled(
    ask: Callable[[Value], list[tuple[Value, Answer]]], body: Body
) -> tuple[Value, list[Answer]]:
    """Return the object's mean velocity [m/s] and the answers of all contacts to it.

    As :func:`.implicit.solve`, for arrays ``(..., dof)``.
    """
    velocity = np.asarray(body.xd)
    least, share = np.array(np.inf), np.array(1.0)
    best = step = velocity
    for _ in range(_LIMIT):
        asked = ask(velocity)
        force = np.asarray(sum(answer.force for _, answer in asked))
        slopes = [_matrix(answer) for _, answer in asked]
        size = sum(
            _length(answer.force) + _length(times(np.abs(slope), np.abs(free)))
            for (free, answer), slope in zip(asked, slopes, strict=True)
        )
        missing = np.asarray(body.imbalance(velocity, force))
        mobility = np.asarray(body.mobility(0.0 * missing))  # without contacts [m/s/N]
        loop = np.eye(force.shape[-1]) + mobility[..., np.newaxis] * sum(slopes)
        change = np.linalg.solve(loop, (mobility * missing)[..., np.newaxis])[..., 0]
        settled = _length(change) <= _ROUNDING * (_length(velocity) + _length(mobility) * size)
        if settled.all():
            break
        length = _length(missing)
        better = settled | (length < least)
        best, step = np.where(better, velocity, best), np.where(better, change, step)
        least, share = np.where(better, length, least), np.where(better, 1.0, 0.5 * share)
        velocity = np.where(settled, velocity, best - share * step)
    return velocity, [answer for _, answer in asked]


def _matrix(answer: Answer) -> Array:
    """Return the slope as a matrix ``(..., dof, dof)`` [N s/m]."""
    slope = np.asarray(answer.slope)
    if isinstance(answer, CoupledAnswer):
        return slope
    return slope[..., np.newaxis] * np.eye(np.shape(answer.force)[-1])


def _length(vector: Value) -> Array:
    return np.asarray(np.linalg.norm(vector, axis=-1, keepdims=True))
