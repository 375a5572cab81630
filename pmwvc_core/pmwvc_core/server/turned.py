# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Handles and their devices turn by the same waves, but not to the same orientation: the turns
between two samples of a moving axis do not add up. What they drifted apart is repaid.

Since a user joined, its device turned by M and its handle by S, along the ways m and s of axes 4
to 6 (l times the sum of the turns). Waves in flight part ways and orientations alike; the drift e

    exp(e/l) = exp(-(m - s)/l) M S^-1

is what they do not explain. As a port that guesses forces does, this one moves the handle
faster by ``REPAID`` e/h, of which the waves do not know, where a compensation pays for it.
Equations: docs/theory.md 5.19.
"""

from typing import Any

import numpy as np

from pmwvc_core.numeric import AXES, Array, Value
from pmwvc_core.params import ServerParams
from pmwvc_core.server.couplings import COMPENSATIONS
from pmwvc_core.transport.orientation import IDENTITY, Orientation

REPAID = 0.3  # of the drift in a step, as of what waves and avatar are apart
LARGEST_RAD_S = 0.5  # a device whose orientation jumps turns nobody's hand


class Turned:
    """Orientations of handles, and of devices by their newest packets, of ``(users, dof)``."""

    def __init__(self, shape: tuple[int, int], server: ServerParams) -> None:
        self.handles = [list(IDENTITY if shape[1] == AXES else ())] * shape[0]
        self.devices: list[tuple[Value, Orientation] | None] = [None] * shape[0]  # and x [m]
        self.since: dict[int, tuple[Array, Any]] = {}  # users joined
        self._shape, self._lever_m, self._known = shape, server.lever_m, False
        self.repays = COMPENSATIONS.of(server.compensation).limits

    def look(self, environment: object) -> None:
        """Note how handles are turned, where an environment says it."""
        if self._shape[1] == AXES and hasattr(environment, "turned"):
            self.handles, self._known = np.asarray(environment.turned).tolist(), True

    def repaying(self, places: Array, there: tuple[bool, ...], h: float) -> Array:
        """Return the velocities ``(users, dof)`` that bring handles back [m/s]."""
        wish, most = np.zeros(self._shape), LARGEST_RAD_S * self._lever_m
        if not (self.repays and self._known):
            return wish
        from scipy.spatial.transform import Rotation  # takes long; only six axes need it

        for user, seen in enumerate(self.devices):
            if seen and there[user]:
                lag, device = seen[0] - places[user], Rotation.from_quat(seen[1])
                handle = Rotation.from_quat(self.handles[user])
                before, turn = self.since.setdefault(user, (lag, device.inv() * handle))
                back = Rotation.from_rotvec((before - lag)[3:] / self._lever_m)
                apart = (back * device * turn * handle.inv()).as_rotvec()
                e = REPAID / h * self._lever_m * apart
                wish[user, 3:] = e * min(1.0, most / max(float(np.linalg.norm(e)), most))
        return wish
