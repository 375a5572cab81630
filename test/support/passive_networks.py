# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Environments for tests: random networks of masses, springs and dampers, and active ones.

A network is stepped by backward Euler, with avatars that move by dt xd: then sum F . xd dt is at
least the gain of what springs and masses hold, whatever the waves. It tells its energy or not.
"""

import numpy as np


class Network:
    """Avatars and masses joined to each other and to ground by springs and dampers."""

    def __init__(self, users, masses, *, stiffness, damping):
        """``masses`` (n,) in kg; ``stiffness``, ``damping`` Laplacians (users + n, users + n)."""
        self.users, self.masses = users, np.asarray(masses, float)
        self.stiffness, self.damping = stiffness, damping
        self.place = self.speed = self.start = None

    def step(self, position, velocity, dt):
        users, n = self.users, len(self.masses)
        if self.place is None:
            shape = position.shape[1:]
            self.start = position - dt * velocity
            self.place, self.speed = np.zeros((users + n, *shape)), np.zeros((n, *shape))
        self.place[:users] = position - self.start - dt * velocity
        both = self.damping + dt * self.stiffness  # force at the end per velocity
        pull = np.tensordot(self.stiffness, self.place, 1)
        given = pull[users:] + np.tensordot(both[users:, :users], velocity, 1)
        inert = np.diag(self.masses / dt)
        kick = np.tensordot(inert, self.speed, 1)
        flat = (kick - given).reshape(n, position[0].size)
        self.speed = np.linalg.solve(inert + both[users:, users:], flat).reshape(self.speed.shape)
        moves = np.concatenate([velocity, self.speed])
        self.place = self.place + dt * moves
        return pull[:users] + np.tensordot(both[:users], moves, 1)


class OpenNetwork(Network):
    """One that tells what it holds."""

    @property
    def energy(self):
        if self.place is None:
            return 0.0
        springs = np.tensordot(self.stiffness, self.place, 1) * self.place
        motion = self.speed**2 * self.masses.reshape(-1, *[1] * (self.speed.ndim - 1))
        held = 0.5 * (springs.sum(axis=(0, -1)) + motion.sum(axis=(0, -1)))
        return np.maximum(held, 0.0)[..., np.newaxis] if held.ndim else max(float(held), 0.0)


def laplacian(rng, nodes, *, largest, density):
    """Draw springs (or dampers) between random nodes and to ground: symmetric, not negative."""
    found = np.diag(largest * rng.random(nodes) ** 3 * (rng.random(nodes) < density))
    for i in range(nodes):
        for j in range(i):
            if rng.random() < density:
                across = np.zeros(nodes)
                across[i], across[j] = 1.0, -1.0
                found = found + largest * rng.random() ** 3 * np.outer(across, across)
    return found


def random_network(rng, users, *, kind=Network):
    """Draw a network: up to four masses from 10 g to 10 kg, springs up to 5000 N/m."""
    count = int(rng.integers(0, 5))
    density = rng.uniform(0.2, 0.9)
    return kind(
        users,
        10.0 ** rng.uniform(-2.0, 1.0, count),
        stiffness=laplacian(rng, users + count, largest=5000.0, density=density),
        damping=laplacian(rng, users + count, largest=50.0, density=density),
    )


class Pusher:
    """Pushes every avatar with a force of its own, whatever it does: active."""

    def __init__(self, force, *, rest=0):
        self.force, self.rest, self.count = force, rest, 0

    def step(self, position, velocity, dt):
        self.count += 1
        if self.count <= self.rest:
            return 5.0 * velocity  # takes energy, stores none
        return self.force + 0.0 * velocity
