# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Characteristic polynomials of App. C, and the Jury-Marden test.

One device (a mass m) at a wall (K, B; trapezoid), everything at one rate, no filter. With v_s = R
u_s at the wall and the events of a tick in the order of the simulator (u_s(n) = u_m(n-1), v_m(n) =
v_s(n), the device under a held force) the loop closes as::

    (z - 1)(1 + R/z) + beta (1 - R/z) = 0,      R = (1 - h)/(1 + h)                  loop solved
                                                R = (1 + h/z - 2 h)/(1 + h/z)        one step late

    h = [alpha (z+1)/2 + sigma (z-1)] / [beta (z-1)]
    alpha = K T^2/m,  beta = b T/m,  sigma = B T/m

The printed polynomials (Eq. 6 and 7) do not follow from one diagram: in both u_m uses v_s(n-1)
while F_m uses v_s(n), and u_s(n) = u_m(n); Eq. 6 besides has v_s(n) = u_s(n-1) - sqrt(2/b) F_s(n),
against Eq. 11. Both are here, to be shown beside ours. Without damping (sigma = 0) ours is never
stable: a sampled mass gives out a little energy, and nothing takes it.

Numbers may be floats, fractions (then everything is exact) or arrays of floats.

Equations: docs/theory.md 5.11.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

Polynomial = list[Any]  # coefficients, highest power first
CASES = ("unwrapped", "one_step_delay")


def loop_polynomial(case: str, alpha: Any, beta: Any, sigma: Any) -> Polynomial:
    """Return the characteristic polynomial of the loop as it runs, times 2 beta."""
    numerator, denominator = reflection(case, alpha, beta, sigma)
    z_denominator = times(denominator, [1, 0])
    moving = times([1, -1], plus(z_denominator, numerator))
    return plus(moving, times([beta], plus(z_denominator, times([-1], numerator))))


def printed_polynomial(case: str, alpha: Any, beta: Any, sigma: Any) -> Polynomial:
    """Return the polynomial as printed (Eq. 6 or 7), in alpha, beta and sigma.

    Every term of the print is m b, m B, m K T, b^2 T, b B T or b K T^2; divided by m^2/T these are
    beta, sigma, alpha, beta^2, beta sigma and alpha beta.
    """
    a, b, s = alpha, beta, sigma
    if case == "one_step_delay":
        return [
            2 * b,
            4 * b * a - 2 * s - 2 * b * b + 8 * b * s - a - 2 * b,
            b * a - 2 * b - 14 * b * s + 6 * s + a + 4 * b * b,
            2 * b + a - 2 * b * a - 2 * b * b - 6 * s + 8 * b * s,
            2 * s - a + b * a - 2 * b * s,
        ]
    return [
        a / 2 + s + b,
        -2 * b - 4 * s + 5 * b * s - a + 5 * b * a / 2 + b * b,
        -9 * b * s - 3 * b * b + 6 * s + b * a / 2 + 2 * b,
        3 * b * b - 3 * b * a / 2 + 5 * b * s - 4 * s - 2 * b + a,
        -a / 2 - b * b - b * s + b + b * a / 2 + s,
    ]


def contact(alpha: Any, beta: Any, sigma: Any) -> Polynomial:
    """Return 2 beta (z-1) h."""
    return [alpha + 2 * sigma, alpha - 2 * sigma]


def reflection(case: str, alpha: Any, beta: Any, sigma: Any) -> tuple[Polynomial, Polynomial]:
    """Return numerator and denominator of R."""
    if case not in CASES:
        raise ValueError(f"case = {case!r}: must be one of {', '.join(CASES)}")
    h, step = contact(alpha, beta, sigma), [2 * beta, -2 * beta]
    if case == "unwrapped":
        return plus(step, times([-1], h)), plus(step, h)
    late = plus(times(step, [1, 0]), h)
    return plus(late, times([-2, 0], h)), late


def times(left: Polynomial, right: Polynomial) -> Polynomial:
    """Multiply polynomials."""
    product: Polynomial = [0] * (len(left) + len(right) - 1)
    for i, a in enumerate(left):
        for j, b in enumerate(right):
            product[i + j] = product[i + j] + a * b
    return product


def plus(left: Polynomial, right: Polynomial) -> Polynomial:
    """Add polynomials."""
    size = max(len(left), len(right))
    left, right = [0] * (size - len(left)) + left, [0] * (size - len(right)) + right
    return [a + b for a, b in zip(left, right, strict=True)]


def jury_marden(coefficients: Sequence[Any]) -> Any:
    """Tell whether all roots lie inside the unit circle (Jury-Marden).

    As long as a polynomial a_0 z^n + ... + a_n has |a_n| < |a_0|, it has the property exactly if
    the one of lower degree with a_0 a_j - a_n a_{n-j} has.

    Parameters
    ----------
    coefficients
        Highest power first; numbers, or arrays (one polynomial per element).
    """
    a = list(coefficients)
    inside: Any = True
    while len(a) > 1:
        inside = inside & (abs(a[-1]) < abs(a[0]))
        first, last = a[0], a[-1]
        a = [first * a[j] - last * a[-1 - j] for j in range(len(a) - 1)]
        if isinstance(a[0], np.ndarray):  # keep numbers from running away
            scale = np.max([np.abs(c) for c in a], axis=0)
            a = [c / np.where(scale > 0.0, scale, 1.0) for c in a]
    return inside
