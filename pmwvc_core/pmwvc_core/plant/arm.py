# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The motion of an arm over a tick by the implicit midpoint rule: its spring and damper never
generate energy, whatever the tick.
"""

from pmwvc_core.numeric import Value


def arm_step(
    yd: Value, drive: Value, twice_mass: Value, inertia: Value, tick_s: float
) -> tuple[Value, Value]:
    """Return how far an arm moves in a tick [m], and its velocity afterwards [m/s].

    It has the velocity ``yd`` before [m/s]; ``drive`` is the force on it if it stayed where it is
    [N], ``inertia`` 2 m + T D + T^2 K/2 of its damper D and spring K [kg].
    """
    velocity = (twice_mass * yd + tick_s * drive) / inertia  # the mean of the tick
    return tick_s * velocity, 2.0 * velocity - yd
