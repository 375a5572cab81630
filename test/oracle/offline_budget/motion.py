# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The velocities within a period, at the nodes of a quadrature."""

import math

import numpy as np

from pmwvc_core.numeric import Array

# Gauss-Legendre: exact for the square of a velocity that is a polynomial up to the third degree.
NODES, WEIGHTS = np.polynomial.legendre.leggauss(4)


def speeds(mass: float, damping: float, period_s: float, xd: Array, force: Array) -> list[Array]:
    """Return the velocities at the nodes of a period that starts with ``xd`` under a force."""
    found = []
    for node in NODES:
        t = 0.5 * (1.0 + node) * period_s
        if damping > 0.0:
            kept = math.exp(-damping * t / mass)
            found.append(xd * kept + force / damping * (1.0 - kept))
        else:
            found.append(xd + force / mass * t)
    return found
