# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The shared object: m_o x'' + b_o x' = sum of the contact forces (App. B, Eq. 1).

Two ways to go one step on: exactly under forces held over the step (what sampled couplings use),
and by the midpoint rule (implicit coupling), which keeps the account of kinetic energy to
rounding::

    m_o (v1 - v0)/h + b_o v = F,   v = (v0 + v1)/2,   x1 = x0 + h v

Not here: contacts and where the forces come from.

Equations: docs/theory.md 4.2.
"""

from typing import Protocol

import numpy as np

from pmwvc_core.numeric import Value, dot, squared
from pmwvc_core.state import Stateful


class Body(Protocol):
    """What the avatars touch. Position, velocity, forces: ``(..., dof)``."""

    x: Value  # [m]
    xd: Value  # [m/s]

    @property
    def kinetic(self) -> Value:
        """Kinetic energy [J]."""
        ...

    def push(self, force: Value) -> tuple[Value, Value]:
        """Go one step on under a held force [N]; return displacement [m] and lost energy [J]."""
        ...

    def imbalance(self, velocity: Value, force: Value) -> Value:
        """Return the force [N] missing for a mean velocity [m/s] under a mean force [N]."""
        ...

    def mobility(self, slope: Value) -> Value:
        """Return the mean velocity [m/s] per force when contacts add ``slope`` [N s/m]."""
        ...

    def drift(self, velocity: Value) -> Value:
        """Go one step on at a mean velocity [m/s]; return the energy lost to ground [J]."""
        ...


def _held(damping: Value, mass: Value, period: float) -> tuple[Value, Value, Value]:
    """Return exp(-z), (1 - exp(-z))/z, (z - 1 + exp(-z))/z^2 for z = damping period/mass >= 0."""
    z = np.asarray(damping * period / mass, dtype=float)
    series = sum((-z) ** k / float(np.prod(np.arange(1, k + 3))) for k in range(10))
    safe = np.where(z > 0.1, z, 1.0)
    second = np.where(z > 0.1, (safe + np.expm1(-safe)) / safe**2, series)
    decay, first = np.exp(-z), 1.0 - z * second
    if z.ndim == 0:
        return float(decay), float(first), float(second)
    return decay, first, second


class Cube(Stateful):
    """The free object. Starts at rest at the origin.

    Parameters
    ----------
    mass, damping : Value
        m_o [kg] and b_o [N s/m]; floats or ``(runs, 1)``.
    period : float
        Time step h [s].
    """

    SIGNALS = "x xd"

    def __init__(self, mass: Value, damping: Value, *, period: float) -> None:
        self.mass = mass
        self.damping = damping
        self.x: Value = 0.0
        self.xd: Value = 0.0
        self._period = period
        self._inertance = 2.0 * mass / period  # [N s/m]
        decay, first, second = _held(damping, mass, period)
        self._decay = decay
        self._glide = period * first
        self._kick = period / mass * first
        self._shove = period * period / mass * second

    @property
    def kinetic(self) -> Value:
        """m_o |xd|^2 / 2 [J]."""
        return 0.5 * self.mass * squared(self.xd)

    def push(self, force: Value) -> tuple[Value, Value]:
        """Go one step on exactly; the energy lost to ground is work minus gain in motion."""
        before = self.kinetic
        moved = self._glide * self.xd + self._shove * force
        self.xd = self._decay * self.xd + self._kick * force
        self.x = self.x + moved
        return moved, dot(force, moved) - (self.kinetic - before)

    def imbalance(self, velocity: Value, force: Value) -> Value:
        """Return (2 m/h + b_o) v - 2 m/h v0 - force."""
        return self._inertance * (velocity - self.xd) + self.damping * velocity - force

    def mobility(self, slope: Value) -> Value:
        """Return 1/(2 m/h + b_o + slope)."""
        return 1.0 / (self._inertance + self.damping + slope)

    def drift(self, velocity: Value) -> Value:
        """Go one step on at the mean velocity; return h b_o |v|^2."""
        self.x = self.x + self._period * velocity
        self.xd = 2.0 * velocity - self.xd
        return self._period * self.damping * squared(velocity)
