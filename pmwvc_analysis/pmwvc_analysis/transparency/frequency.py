# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Frequency response of a multirate model, at the frequency of the force.

A force f_i(k) = p_i exp(j theta k) on user i gives, lifted over a hyperperiod of N ticks, the
input w exp(j theta N n) with w[i, k] = p_i exp(j theta k), p_i a vector where axes are coupled.
States and packets follow from the equations of
:meth:`.loop.LinearLoop.equations` at Z = exp(j theta N), whatever
the delay. Of what comes out, with its images at theta + 2 pi j/N, the component at theta is the
mean of y(k) exp(-j theta k) over the hyperperiod.

Equations: docs/theory.md 12.1, 12.2.
"""

from collections.abc import Callable, Sequence

import numpy as np

from pmwvc_analysis.models.loop import LinearLoop
from pmwvc_analysis.models.response import OUTPUTS
from pmwvc_core.numeric import Array, Complex
from pmwvc_core.wave.aliasing import peak

LEAST_TURN = 1e-6  # from images of rest, where integrators have no response
AT_ONCE = 4_000_000  # complex numbers: 64 MB
LOW_HZ = 0.04  # where limits at rest are taken, at most


def response(
    loop: LinearLoop,
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
    users, ticks, dof = len(loop.scenario.users), loop.ticks, loop.dof
    axis = axis if dof > 1 else 0
    pattern = np.zeros((users, dof))
    if forces is None:
        pattern[user, axis] = 1.0
    else:
        pattern[:] = np.asarray(forces, dtype=float).reshape(users, dof)
    turns = np.asarray(frequency_hz, dtype=float) * loop.tick_s * ticks  # per hyperperiod
    whole = np.round(turns)
    turns = np.where(np.abs(turns - whole) < LEAST_TURN, whole + LEAST_TURN, turns)
    angle = 2.0 * np.pi * turns / ticks
    wave = np.exp(1j * np.multiply.outer(angle, np.arange(ticks)))  # (points, ticks)
    lifted = np.einsum("ua,pt->puta", pattern, wave).reshape(len(angle), users * ticks * dof)
    first = (user * len(OUTPUTS) + OUTPUTS.index(output)) * ticks * dof + axis
    rows, read = loop.system
    read = read[first : first + ticks * dof : dof]
    driven = lifted @ rows[:, len(rows) :].T  # (points, states and what comes in)
    turn, found = np.exp(1j * angle * ticks), np.empty_like(driven)
    some = max(1, AT_ONCE // len(rows) ** 2)
    for begin in range(0, len(angle), some):
        of = slice(begin, begin + some)
        equations = loop.equations(turn[of])
        found[of] = np.linalg.solve(equations, driven[of, :, np.newaxis])[..., 0]
    values = np.concatenate([found, lifted], axis=1) @ read.T
    return np.asarray((values * wave.conj()).mean(axis=1))


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
            return peak(size_at, frequency[peaks[0] :][:3])[0]
    return None
