# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Frequency response of a multirate model, at the frequency of the force.

A force f_i(k) = p_i exp(j theta k) on user i gives, lifted over a hyperperiod of N ticks, the
input w exp(j theta N n) with w[i, k] = p_i exp(j theta k), p_i a vector where axes are coupled.
The state follows with (exp(j theta N) - A)^-1 B w. Of what comes out, with its images at theta + 2
pi j/N, the component at theta is the mean of y(k) exp(-j theta k) over the hyperperiod.

A state that only takes over another one (a delay line has one per packet under way) is that one
turned back by exp(-j theta N), put in before solving: long delays cost little.

Equations: docs/theory.md 12.1, 12.2.
"""

from collections.abc import Callable, Sequence

import numpy as np

from pmwvc_analysis.models.linearize import Linear
from pmwvc_analysis.models.windings import refined
from pmwvc_core.numeric import Array, Complex, Integers

LEAST_TURN = 1e-6  # from images of rest, where integrators have no response
AT_ONCE = 4_000_000  # complex numbers: 64 MB
LOW_HZ = 0.04  # where limits at rest are taken, at most


def response(
    model: Linear,
    frequency_hz: Array,
    *,
    output: str = "x",
    user: int = 0,
    forces: Sequence[float] | Array | None = None,
    axis: int = 0,
) -> Complex:
    """Return the base-band response of one user's ``x``, ``xd`` or ``f`` along an axis to the
    hands' forces, ``(points,)`` per unit of their amplitudes, above zero and up to half the tick
    rate. ``forces`` are amplitude and sign p_i per user, of several axes of the model ``(users,
    dof)``; by default the one looked at pushes alone along the axis.
    """
    users, ticks, dof = len(model.loop.lines), model.ticks, model.loop.dof
    axis = axis if dof > 1 else 0
    pattern = np.zeros((users, dof))
    if forces is None:
        pattern[user, axis] = 1.0
    else:
        pattern[:] = np.asarray(forces, dtype=float).reshape(users, dof)
    turns = np.asarray(frequency_hz, dtype=float) * model.loop.tick_s * ticks  # per hyperperiod
    whole = np.round(turns)
    turns = np.where(np.abs(turns - whole) < LEAST_TURN, whole + LEAST_TURN, turns)
    angle = 2.0 * np.pi * turns / ticks
    wave = np.exp(1j * np.multiply.outer(angle, np.arange(ticks)))  # (points, ticks)
    lifted = np.einsum("ua,pt->puta", pattern, wave).reshape(len(angle), users * ticks * dof)
    kept, source, steps = _taken_over(model)
    at = np.searchsorted(kept, source)
    gather = np.eye(len(kept))[at]  # (states, kept)
    turn = np.exp(1j * angle * ticks)
    back = turn[:, np.newaxis] ** -steps  # (points, states)
    driven = (lifted @ model.inputs[kept].T)[..., np.newaxis]
    state = np.empty_like(back)
    some = max(1, AT_ONCE // max(gather.size, 1))
    for first in range(0, len(angle), some):
        of = slice(first, first + some)
        inner = (model.transition[kept] * back[of, np.newaxis, :]) @ gather
        resolvent = turn[of, np.newaxis, np.newaxis] * np.eye(len(kept)) - inner
        state[of] = back[of] * np.linalg.solve(resolvent, driven[of])[..., 0][:, at]
    rows = slice(user * ticks * dof + axis, (user + 1) * ticks * dof, dof)
    signal = model.outputs[output]
    values = state @ signal.state[rows].T + lifted @ signal.through[rows].T
    return np.asarray((values * wave.conj()).mean(axis=1))


def _taken_over(model: Linear) -> tuple[Integers, Integers, Integers]:
    """Return the states to solve for in order, per state which of them it repeats, and by how many
    hyperperiods late.
    """
    rows, count = model.transition, len(model.states)
    before = np.argmax(rows != 0.0, axis=1)
    own = np.arange(count)
    repeats = (np.count_nonzero(rows, axis=1) == 1) & (rows[own, before] == 1.0)
    repeats &= (before != own) & ~model.inputs.any(axis=1)
    source, steps = own.copy(), np.zeros(count, dtype=np.int64)
    for _ in range(count):
        late = repeats[source]
        if not late.any():
            return np.flatnonzero(~repeats), source, steps
        source, steps = np.where(late, before[source], source), steps + late
    return own, own, np.zeros(count, dtype=np.int64)  # states that repeat each other in a ring


def limit_at_rest(values: Array) -> float:
    """Return the limit at zero of a series in the square of the frequency (Richardson), of its
    values at f, 2 f, 4 f... as :func:`low_hz` returns them.
    """
    left, factor = np.asarray(values, dtype=float), 4.0
    while len(left) > 1:
        left, factor = (factor * left[:-1] - left[1:]) / (factor - 1.0), 4.0 * factor
    return float(left[0])


def low_hz(peak_hz: float | None) -> Array:
    """Return f, 2 f, 4 f, 8 f [Hz]: low enough for a limit at rest (the first peak gives how far
    up the series holds), high enough for the rounding that integrators make grow towards rest.
    """
    lowest = LOW_HZ if peak_hz is None else min(LOW_HZ, peak_hz / 64.0)
    return lowest * np.array([1.0, 2.0, 4.0, 8.0])


def first_peak_hz(at: Callable[[Array], Complex], tick_s: float) -> float | None:
    """Return the lowest frequency [Hz] at which a response has a maximum, None without one."""

    def size_at(frequency: Array) -> Array:
        return np.abs(at(frequency))

    frequency, size = np.geomspace(0.05, 0.5 / tick_s, 800), np.zeros(0)
    while len(size) < len(frequency):  # from below, no further than to the first one
        size = np.append(size, size_at(frequency[len(size) : len(size) + 100]))
        peaks = np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] > size[2:]))
        if len(peaks):
            return refined(size_at, frequency[peaks[0]], frequency[peaks[0] + 2], rounds=4)[1]
    return None
