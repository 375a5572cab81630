# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Exact motion of a damped mass under a constant force.

m x'' + b x' = F over a time t, with z = b t / m, has the solution

    xd(t) = e^-z xd + (t/m) phi1(z) F
    x(t)  = x + t phi1(z) xd + (t^2/m) phi2(z) F
    phi1(z) = (1 - e^-z)/z,  phi2(z) = (z - 1 + e^-z)/z^2

which is what the matrix exponential of the zero-order-held system gives. The limits for z -> 0
(no damping: 1 and 1/2) are taken smoothly. The heat of the damper, b times the integral of |xd|^2,
is taken from the velocity itself, not from the balance of the other energies: by Gauss-Legendre
with four nodes, as good as exact where b t/m is small. Not here: friction and stops, see
``devices``.

Equations: those of :mod:`pmwvc_core.law.plant.motion`, for arrays.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pmwvc_core.numeric import Value, squared

SERIES_BELOW = 0.1  # phi2 by its series there: the closed form loses digits to cancellation
_OUTER, _INNER = (math.sqrt(3.0 / 7.0 + s * 2.0 / 7.0 * math.sqrt(1.2)) for s in (1.0, -1.0))
_LIGHT, _HEAVY = ((18.0 - s * math.sqrt(30.0)) / 72.0 for s in (1.0, -1.0))
_NODES = [(0.5 + 0.5 * s * x, w) for x, w in ((_OUTER, _LIGHT), (_INNER, _HEAVY)) for s in (-1, 1)]
_TERMS = [1.0 / math.factorial(n + 2) for n in range(10)]


@dataclass(frozen=True, slots=True)
class Motion:
    """Coefficients of the map from (x, xd, F) to (x, xd) after a given time."""

    xd_x: Value  # [s] of the velocity in the new position
    f_x: Value  # [m/N]
    xd_xd: Value  # [-]
    f_xd: Value  # [m/s/N]

    def advance(self, x: Value, xd: Value, force: Value) -> tuple[Value, Value]:
        """Return position [m] and velocity [m/s] after the time; ``force`` [N] is constant."""
        return (
            x + self.xd_x * xd + self.f_x * force,
            self.xd_xd * xd + self.f_xd * force,
        )


def motion(mass: Value, damping: Value, time_s: Value) -> Motion:
    """Return the exact motion of a damped mass over a time.

    Parameters
    ----------
    mass, damping, time_s
        m [kg], b [N s/m] and t [s]: floats, or arrays that broadcast (``(runs, 1)``).
    """
    z = damping * time_s / mass
    rate = time_s / mass
    phi1 = _each(_phi1, z)
    return Motion(time_s * phi1, time_s * rate * _each(_phi2, z), _each(_decay, z), rate * phi1)


def damper_heat(mass: Value, damping: Value, time_s: Value, xd: Value, force: Value) -> Value:
    """Return b times the integral of |xd|^2 over a time that begins with ``xd`` [J].

    Parameters
    ----------
    mass, damping, time_s
        As for :func:`motion`.
    xd, force
        Velocity at the start [m/s] and constant force [N], ``(..., dof)``.
    """
    square: Value = 0.0
    for node, weight in _NODES:
        _, speed = motion(mass, damping, node * time_s).advance(0.0, xd, force)
        square = square + weight * squared(speed)
    return damping * time_s * square


def time_to_rest(mass: Value, damping: Value, xd: Value, force: Value) -> Value:
    """Return when a constant force has stopped the mass [s].

    From xd(t) = 0: t = -(m xd/F) ln(1 + r)/r with r = -b xd/F. The force opposes the velocity;
    where it does not, the result has no meaning.
    """
    undamped = -mass * xd / force
    return undamped * _each(_log1p_over, undamped * damping / mass)


def _each(function: Callable[[float], float], value: Value) -> Value:
    """Apply a function of one number to every element (where coefficients are formed)."""
    if isinstance(value, np.ndarray):
        return np.array([function(float(item)) for item in value.flat]).reshape(value.shape)
    return function(value)


def _decay(z: float) -> float:
    return math.exp(-z)


def _phi1(z: float) -> float:
    return -math.expm1(-z) / z if z else 1.0


def _phi2(z: float) -> float:
    if z < SERIES_BELOW:
        total, power = 0.0, 1.0
        for term in _TERMS:
            total += term * power
            power *= -z
        return total
    return (z + math.expm1(-z)) / (z * z)


def _log1p_over(r: float) -> float:
    return math.log1p(r) / r if r > 0.0 else 1.0
