# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The shared object, m_o x'' + b_o x' = sum of the contact forces (App. B, Eq. 1), and a wall.

Two ways to go one step on: exactly under forces held over the step (what sampled couplings use),
and by the midpoint rule (implicit coupling), which keeps the account of kinetic energy to
rounding::

    m_o (v1 - v0)/h + b_o v = F,   v = (v0 + v1)/2,   x1 = x0 + h v

Not here: contacts and where the forces come from.

Equations: docs/theory.md 4.2.
"""

from typing import Protocol

import numpy as np

from pmwvc_core.account import Account
from pmwvc_core.motion import damper_heat, motion
from pmwvc_core.numeric import Value, dot, root, squared
from pmwvc_core.state import Stateful


class Body(Protocol):
    """The object that the avatars touch. Position, velocity, forces: ``(..., dof)``."""

    x: Value  # [m]
    xd: Value  # [m/s]

    @property
    def kinetic(self) -> Value:
        """Kinetic energy [J]."""
        ...

    def configure(self, mass: Value, damping: Value, *, period: float) -> None:
        """Take other parameters over [kg], [N s/m], [s]; the energy of motion stays."""
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
        self.x: Value = 0.0
        self.xd: Value = 0.0
        self._take(mass, damping, period)

    def _take(self, mass: Value, damping: Value, period: float) -> None:
        self.mass, self.damping, self._period = mass, damping, period
        self._inertance = 2.0 * mass / self._period  # [N s/m]
        self._motion = motion(mass, damping, self._period)

    def configure(self, mass: Value, damping: Value, *, period: float) -> None:
        """Go on with the velocity at which another mass has the same energy."""
        if np.any(mass != self.mass):
            self.xd = self.xd * root(self.mass / mass)
        self._take(mass, damping, period)

    @property
    def kinetic(self) -> Value:
        """m_o |xd|^2 / 2 [J]."""
        return 0.5 * self.mass * squared(self.xd)

    def push(self, force: Value) -> tuple[Value, Value]:
        """Go one step on exactly; the energy lost to ground is work minus gain in motion."""
        before = self.kinetic
        moved, self.xd = self._motion.advance(0.0, self.xd, force)
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


def object_account(
    mass: Value,
    damping: Value,
    period: Value,
    moved: Value,
    velocity: Value,
    force: Value,
    gained: Value,
    *,
    midpoint: bool,
) -> Account:
    """Return the energy of the object over a step [J]: the forces' work, its gain in motion, and
    the heat of its damper.

    Parameters
    ----------
    moved
        How far it went [m].
    velocity
        With which it began [m/s].
    force
        Sum of the forces on it [N], held over the step.
    gained
        By how much its energy of motion grew [J].
    midpoint
        Whether it went by the midpoint rule: at a mean velocity, so the heat is b_o |moved|^2/h.
    """
    if midpoint:
        heat = damping / period * squared(moved)
    else:
        heat = damper_heat(mass, damping, period, velocity, force)
    return Account(dot(force, moved), stored=gained, dissipated=heat)


class FixedBody(Stateful):
    """An object that never moves: whatever the force, velocity zero, no energy taken."""

    MEMORY = "x xd"

    def __init__(self) -> None:
        self.x: Value = 0.0
        self.xd: Value = 0.0

    @property
    def kinetic(self) -> Value:
        """Zero."""
        return 0.0

    def configure(self, mass: Value, damping: Value, *, period: float) -> None:
        """Stay."""

    def push(self, force: Value) -> tuple[Value, Value]:
        """Stay."""
        return 0.0 * force, 0.0

    def imbalance(self, velocity: Value, force: Value) -> Value:
        """Return zero: a wall bears any force."""
        return 0.0 * force

    def mobility(self, slope: Value) -> Value:
        """Return zero."""
        return 0.0 * slope

    def drift(self, velocity: Value) -> Value:
        """Stay."""
        return 0.0
