# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A second model of both contacts, written from theory.md 4.3, 4.4: mean forces over a step."""

import numpy as np
from scipy.optimize import brentq

NARROW = {"xtol": 1e-16, "rtol": 1e-15, "maxiter": 500}


class Spring:
    """A contact that pulls and pushes; ``e`` is its deflection, ``at`` where it is at rest."""

    def __init__(self, dof, k, damping):
        self.k, self.damping, self.e, self.at = k, damping, np.zeros(dof), np.zeros(dof)

    @property
    def stored_j(self):
        return 0.5 * self.k * float(self.e @ self.e)

    touches = True

    def meet(self, away):
        self.at, self.e = away, np.zeros(len(away))

    def part(self):
        self.e = 0.0 * self.e

    def force(self, free, b, h):
        """The mean force where the mean velocity is free - force/b."""
        gain = 0.5 * self.k * h + self.damping
        return (self.k * self.e + gain * free) / (1.0 + gain / b)

    def room(self, wanted):
        return 0.0 * wanted


class Face:
    """A grip: it pushes along ``n`` only, from the depth zero on; one axis."""

    def __init__(self, k, damping, *, side, size, gap):
        self.k, self.damping, self.gap, self.n = k, damping, gap, -float(side)
        self.at, self.e = np.array([0.5 * side * size]), np.zeros(1)

    @property
    def depth(self):
        return self.n * self.e[0]

    @property
    def stored_j(self):
        return 0.5 * self.k * max(self.depth, 0.0) ** 2

    @property
    def touches(self):
        return self.depth > 0.0

    def meet(self, away):
        self.e = np.array([self.n * min(self.n * (away - self.at)[0], -self.gap)])

    def part(self):
        self.e = np.array([self.n * min(self.depth, 0.0)])

    def _push(self, w, h):
        """The potential's difference quotient and the damper of the way inside (4.3)."""
        p0, p1 = self.depth, self.depth + h * w
        in0, in1 = max(p0, 0.0), max(p1, 0.0)
        spring = self.k * in0 if p1 == p0 else 0.5 * self.k * (in1**2 - in0**2) / (p1 - p0)
        return max(spring + self.damping * (in1 - in0) / h, 0.0)

    def force(self, free, b, h):
        c = self.n * free[0]
        most = self._push(c, h)
        if most == 0.0:
            return np.zeros(1)
        push = brentq(lambda f: f - self._push(c - f / b, h), 0.0, most, **NARROW)
        return np.array([self.n * push])

    def room(self, wanted):
        """How far the avatar may slide: never into contact, the gap stays."""
        if self.touches:
            return 0.0 * wanted
        return self.n * np.minimum(self.n * wanted, max(-self.depth - self.gap, 0.0))
