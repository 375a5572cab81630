# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A soft body that stands still, after Hunt and Crossley: F = K d^n (1 + c d') while d > 0.

d is the depth in the face of the user's own side; along the face nothing holds. The damping grows
with the depth, so the force does not jump where contact begins. It never pulls. Who comes in
inside begins without force: there the face is as deep as that. Moved by h xd with d' = xd it gives
out no more than it got: K d^n is the slope of a convex potential.
"""

import numpy as np

from pmwvc_core.numeric import Array
from pmwvc_core.server.black_box.interface import EnvironmentSetup
from pmwvc_core.state import Stateful


class HuntCrossley(Stateful):
    """Nonlinear contact for every user, with its slope."""

    MEMORY = "_start _depth"

    def __init__(self, setup: EnvironmentSetup) -> None:
        params = setup.server.hunt_crossley
        self._exponent, self._damping = params.exponent, params.damping
        self._sides = setup.sides
        self._stiffness = [contact.contact_stiffness for contact in setup.contacts]
        self._face = 0.5 * setup.server.object_size_m
        self._start: dict[int, Array] = {}  # depth at which everybody came in (..., 1) [m]
        self._depth: dict[int, Array] = {}  # of those who are there, 0 outside (..., 1) [m]

    def join(self, user: int, position: Array) -> None:
        """Begin at a position, without force."""
        self._start[user] = self._beneath(user, position)
        self._depth[user] = 0.0 * self._start[user]

    def leave(self, user: int) -> None:
        """Take a user out."""
        del self._depth[user]

    @property
    def energy(self) -> Array:
        """Sum of K d^(n+1)/(n+1) [J]."""
        n, total = self._exponent, np.zeros(1)
        for user, depth in self._depth.items():
            total = total + self._stiffness[user] * depth ** (n + 1.0) / (n + 1.0)
        return total

    def step(self, position: Array, velocity: Array, dt: float) -> Array:
        """Return the forces at the end of the step."""
        force = np.zeros_like(position)
        for user in self._depth:
            depth = self._depth[user] = self._inside(user, position[user])
            inward = -float(self._sides[user])
            elastic = self._stiffness[user] * depth**self._exponent
            rate = inward * velocity[user][..., :1]
            force[user][..., :1] = inward * elastic * np.maximum(1.0 + self._damping * rate, 0.0)
        return force

    def local(self, position: Array, dt: float) -> tuple[Array, Array]:
        """Return force and slope at a position, without motion; zero outside."""
        force, slope = np.zeros_like(position), np.zeros_like(position)
        for user in self._depth:
            depth, stiffness = self._inside(user, position[user]), self._stiffness[user]
            elastic = stiffness * depth**self._exponent
            rise = self._exponent * stiffness * depth ** (self._exponent - 1.0) * dt
            force[user][..., :1] = -float(self._sides[user]) * elastic
            slope[user][..., :1] = np.where(depth > 0.0, rise + self._damping * elastic, 0.0)
        return force, slope

    def _inside(self, user: int, position: Array) -> Array:
        return np.maximum(self._beneath(user, position) - self._start[user], 0.0)

    def _beneath(self, user: int, position: Array) -> Array:
        return np.maximum(self._face - self._sides[user] * position[..., :1], 0.0)
