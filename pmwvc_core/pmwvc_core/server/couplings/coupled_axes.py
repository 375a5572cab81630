# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The implicit step where a wave impedance couples the axes: one vector equation for the object.

With r(v) the force that is missing at a mean velocity v of the object, dr/dv is symmetric and at
least 2 m_o/h + b_o (the contacts' slopes are symmetric and not negative): r is the gradient of a
convex function, so it has one root. Newton's step c is damped by a line search on r itself: along
v - t c the derivative g(t) = -c . r(v - t c) of that function never falls with t, and g(0) < 0. So
any t with g(t) <= 0 goes downhill; t is bisected between such a t and one beyond, until |g| has
halved. With two-sided contacts alone the first step is the closed form.

It ends at rounding. Where the matrices are so ill-conditioned that rounding is larger, a residual
of 1e-9 of the forces is taken once Newton's step no longer halves it; a run with more than that in
the end has not settled, and is reported: its energy balances only to the residual.

Equations: docs/theory.md 6.6.
"""

import sys
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from pmwvc_core.numeric import Array, Flags, Value, dot
from pmwvc_core.server.contacts import Answer
from pmwvc_core.server.coupled_axes import CoupledAnswer
from pmwvc_core.server.cube import Body
from pmwvc_core.wave.impedance import times

Ask = Callable[[Value], list[tuple[Value, Answer]]]

_ROUNDING = 8.0 * sys.float_info.epsilon
_TAKEN = 1e-9
_STEPS = 60  # of Newton's method
_CUTS = 50  # of one line search
_FLAT = 0.5  # of g(0): the line search is done


class Looked(NamedTuple):
    """The equation at one velocity."""

    velocity: Array
    answers: list[Answer]
    missing: Array  # (..., dof) [N] r
    change: Array  # (..., dof) [m/s] Newton's step
    settled: Flags  # (..., 1) to rounding
    close: Flags  # (..., 1) to what is taken


def solve_coupled(ask: Ask, body: Body) -> tuple[Value, list[Answer], Flags]:
    """Return the object's mean velocity [m/s], the answers of all contacts to it, and which runs
    settled, ``(..., 1)``.

    As :func:`.implicit.solve`, for arrays ``(..., dof)``.
    """
    here = _look(ask, body, np.asarray(body.xd))
    for _ in range(_STEPS):
        if here.settled.all():
            break
        there = _downhill(ask, body, here)
        slow = _length(there.missing) > 0.5 * _length(here.missing)
        stuck = np.all(there.velocity == here.velocity, axis=-1, keepdims=True)
        if (here.settled | stuck | (here.close & slow)).all():
            break
        here = there
    return here.velocity, here.answers, here.settled | here.close


def _downhill(ask: Ask, body: Body, here: Looked) -> Looked:
    """Return the equation at the end of a damped step; settled runs stay."""
    course = np.where(here.settled, 0.0, here.change)
    steep = np.abs(np.asarray(dot(course, here.missing)))
    low, high = np.zeros_like(steep), np.full_like(steep, 2.0)
    step_ratio = np.ones_like(steep)
    found = here
    for _ in range(_CUTS):
        found = _look(ask, body, here.velocity - step_ratio * course)
        gain = np.asarray(dot(-course, found.missing))  # g(t)
        done = here.close | found.settled | ((gain <= 0.0) & (gain >= -_FLAT * steep))
        done |= (gain <= 0.0) & (step_ratio >= 1.0)
        if done.all():
            return found
        low = np.where(done | (gain <= 0.0), step_ratio, low)
        high = np.where(~done & (gain > 0.0), step_ratio, high)
        step_ratio = np.where(done, step_ratio, 0.5 * (low + high))
    return _look(ask, body, here.velocity - low * course)


def _look(ask: Ask, body: Body, velocity: Array) -> Looked:
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
    scale = _length(velocity) + _length(mobility) * size
    settled = _length(change) <= _ROUNDING * scale
    close = settled | (_length(mobility * missing) <= _TAKEN * scale)
    return Looked(velocity, [answer for _, answer in asked], missing, change, settled, close)


def _matrix(answer: Answer) -> Array:
    """Return the slope as a matrix ``(..., dof, dof)`` [N s/m]."""
    slope = np.asarray(answer.slope)
    if isinstance(answer, CoupledAnswer):
        return slope
    return slope[..., np.newaxis] * np.eye(np.shape(answer.force)[-1])


def _length(vector: Value) -> Array:
    return np.asarray(np.linalg.norm(vector, axis=-1, keepdims=True))
