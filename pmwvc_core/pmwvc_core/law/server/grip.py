# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The one-sided contact along one axis: an avatar pushes the face of its own side and never pulls.

With the depth ``p`` in the face (negative outside) and the inward direction n = -side::

    N = max(0, K p + B p')  while p > 0, else 0        force on the object: f = n N

The mean force of a step from p0 to p1 = p0 + h w is the difference quotient of the potential
phi(p) = K max(p, 0)^2 / 2, and the damper acts on the part of the way inside::

    N = max(0, [phi(p1) - phi(p0)] / (p1 - p0) + B [max(p1, 0) - max(p0, 0)] / h)

N never falls with w, so with w = c - N/b it has exactly one solution, piece by piece a quadratic.
Here p, c and w count inwards.

Equations: docs/theory.md 4.3.
"""

import math
from typing import NamedTuple


class Answer(NamedTuple):
    """The answer of a contact to the velocity that its avatar would have without it, per axis."""

    force: float  # [N] on the object
    rate: float  # [m/s] relative velocity, mean over the step
    slope: float  # [N s/m] by how much the force falls per velocity of the object


def pushed(p0: float, c: float, k: float, damping: float, b: float, h: float) -> Answer:
    """Solve the mean law together with w = c - N/b; counts inwards."""
    if p0 > 0.0:
        push = _staying(p0, c, k, damping, b, h)
        if not p0 + h * push.rate >= 0.0:
            push = _leaving(p0, c, k, damping, b, h)
    elif p0 + h * c > 0.0:
        push = _entering(p0, c, k, damping, b, h)
    else:
        return Answer(0.0, c, 0.0)
    if push.force > 0.0:
        return push._replace(slope=push.slope / (1.0 + push.slope / b))
    return Answer(0.0, c, 0.0)


def _staying(p0: float, c: float, k: float, damping: float, b: float, h: float) -> Answer:
    """Inside at both ends: N = K p0 + (K h/2 + B) w."""
    gain = 0.5 * k * h + damping
    ratio = 1.0 + gain / b
    pull = k * p0
    return Answer((pull + gain * c) / ratio, (c - pull / b) / ratio, gain)


def _leaving(p0: float, c: float, k: float, damping: float, b: float, h: float) -> Answer:
    """Inside at the start only: N = K p0^2/(2 h s) - B p0/h, s = -w, s^2 + beta s = gamma."""
    beta = c + damping * p0 / (h * b)
    gamma = 0.5 * k * p0 * p0 / (h * b)
    size = math.sqrt(beta * beta + 4.0 * gamma)
    speed = 0.5 * (size - beta)
    if beta > 0.0:
        speed = 2.0 * gamma / (beta + size)
    way = h * speed
    ratio = p0 / way if way > 0.0 else p0  # of the way that is inside
    normal = 0.5 * k * p0 * ratio - damping * p0 / h
    return Answer(normal, -speed, 0.5 * h * k * ratio * ratio)


def _entering(p0: float, c: float, k: float, damping: float, b: float, h: float) -> Answer:
    """Inside at the end only: p1 is the positive root of a p^2 - 2 q p = g, g >= 0.

    The depth without resistance, p0 + h c > 0, is the only small difference in it.
    """
    reach = max(p0 + h * c, 0.0)
    a = b + 0.5 * h * k + damping
    q = 0.5 * ((b + damping) * p0 + b * reach)
    g = -b * reach * min(p0, 0.0)
    size = math.sqrt(q * q + a * g)
    p1 = (q + size) / a
    if q <= 0.0:
        less = size - q
        p1 = g / less if less > 0.0 else g
    way = p1 - p0 if p1 > p0 else 1.0
    ratio = p1 / way  # of the way that is inside
    normal = 0.5 * k * p1 * ratio + damping * p1 / h
    return Answer(normal, way / h, 0.5 * h * k * ratio * (2.0 - ratio) + damping)


def met(p0: float, w: float, k: float, damping: float, h: float) -> Answer:
    """Return the mean law for a given w; counts inwards."""
    p1 = p0 + h * w
    in0, in1, way = max(p0, 0.0), max(p1, 0.0), abs(p1 - p0)
    ratio = 1.0
    if p0 < 0.0 or p1 < 0.0:
        ratio = max(in0, in1) / way if way > 0.0 else max(in0, in1)
    normal = ratio * (0.5 * k * (in0 + in1) + damping * w)
    if normal <= 0.0:
        return Answer(0.0, w, 0.0)
    spring = 0.5 * k * h * ratio
    slope = spring * (2.0 - ratio) + damping if p1 > 0.0 else spring * ratio
    return Answer(normal, w, slope)


def sampled(p: float, w: float, k: float, damping: float) -> float:
    """Return max(0, K p + B w) inside the face, else 0."""
    return max(k * p + damping * w, 0.0) if p > 0.0 else 0.0


def unwrapped(p: float, c: float, loose: float, gain: float, b: float, weight: float) -> float:
    """Return the force N = loose/(1 + gain/b) that keeps the avatar inside and pushes, else 0; the
    avatar moves by weight (c - N/b).

    The sampled law jumps where the damper begins to act, so contact begins only once the avatar
    ends inside although it is pushed back.
    """
    normal = loose / (1.0 + gain / b)
    deep = p + weight * (c - normal / b)
    return normal if normal > 0.0 and deep > 0.0 else 0.0
