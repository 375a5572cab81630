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

import numpy as np

from pmwvc_core.numeric import AXES, Array, Value
from pmwvc_core.params import ServerParams
from pmwvc_core.quaternions import IDENTITY, Orientation, carried, turn_between
from pmwvc_core.server.couplings import COMPENSATIONS

REPAID = 0.3  # of the drift in a step, as of what waves and avatar are apart
LARGEST_RAD_S = 0.5  # a device whose orientation jumps turns nobody's hand


class Turned:
    """Orientations of handles, and of devices by their newest packets, of ``(users, dof)``."""

    def __init__(self, shape: tuple[int, int], server: ServerParams) -> None:
        self.handles = [list(IDENTITY if shape[1] == AXES else ())] * shape[0]
        self.devices: list[tuple[Value, Orientation] | None] = [None] * shape[0]  # and x [m]
        self.since: dict[int, tuple[Array, Orientation, Orientation]] = {}  # users joined
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
        for user, seen in enumerate(self.devices):
            if seen and there[user]:
                (at, device), handle = seen, tuple(self.handles[user])
                lag = at - places[user]
                before, m, s = self.since.setdefault(user, (lag, device, handle))
                unexplained = ((before - lag)[3:] / self._lever_m).tolist()
                should_be = carried(carried(s, turn_between(m, device)), unexplained)
                e = REPAID / h * self._lever_m * np.array(turn_between(handle, should_be))
                wish[user, 3:] = e * min(1.0, most / max(float(np.linalg.norm(e)), most))
        return wish
