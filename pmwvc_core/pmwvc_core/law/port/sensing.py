# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The device as a force loop sees it: a sample that is too old, or none, is no sample.

Without one the loop has the position last seen and no velocity, and the limits let no force
through: it is unknown how the device moves.
"""

import math
from typing import NamedTuple

from pmwvc_core.law.vectors import Vector, each, zero

LATE_NS = 5_000_000  # a sample older than this is counted
STALE_NS = 20_000_000  # one older than this is none: the device is silent
NEVER_NS = -(1 << 62)


class Sample(NamedTuple):
    """What a device says at a tick."""

    x: Vector  # [m]
    xd: Vector  # [m/s]
    valid: bool  # position and velocity can be trusted
    measured_ns: int  # when; NEVER_NS where nothing new came since the last sample


def age_ns(sample: Sample, measured_ns: int, now_ns: int) -> float:
    """Return how old a sample is, the newest before having been taken at ``measured_ns``; infinite
    where it is none.
    """
    old = now_ns - max(measured_ns, sample.measured_ns)
    return float(old) if sample.valid and old >= 0 else math.inf


def known_motion(x: Vector, xd: Vector, last: Vector) -> tuple[Vector, Vector]:
    """Return position and velocity; what is not finite counts as the last position and as no
    velocity.
    """
    for i in range(len(x)):
        if not math.isfinite(x[i] + xd[i]):
            return each(_finite, (x, last)), each(_finite, (xd, zero(xd)))
    return x, xd


def _finite(value: float, otherwise: float) -> float:
    return value if math.isfinite(value) else otherwise
