# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Wall and cube as black boxes, with the contact laws of the other couplings.

The wall uses the force at the end of a step, as ``one_step_delay`` does. Moved by h xd (backward
Euler) it gives out no more than it got: K e(n) [e(n) - e(n-1)] is at least the gain of the spring.

The cube is a body that moves by its own force. Pushed by the force of the step before (as the
sampled couplings do) it would make energy; here it moves with the avatars, by the midpoint rule
and the mean force over the step (``couplings.implicit``), so that sum f_i xd_i h is stored or heat
to rounding.
"""

import copy

import numpy as np

from pmwvc_core.numeric import Array, Value, where
from pmwvc_core.server.black_box.interface import EnvironmentSetup
from pmwvc_core.server.contacts import Answer, Contact
from pmwvc_core.server.couplings.implicit import solve
from pmwvc_core.server.cube import Cube
from pmwvc_core.server.factory import make_contact
from pmwvc_core.state import Stateful


class Touched(Stateful):
    """The contacts of all users, and their positions at the end of the last step."""

    BLOCKS = "contacts"
    MEMORY = "at position velocity"

    def __init__(self, setup: EnvironmentSetup) -> None:
        self.contacts: list[Contact] = [
            make_contact(contact, side=side, size=setup.server.object_size_m, dof=setup.dof)
            for contact, side in zip(setup.contacts, setup.sides, strict=True)
        ]
        self.at: dict[int, Value] = {}  # who is there, and where [m]
        self.position: Value = np.zeros(setup.dof)  # of the object
        self.velocity: Value = np.zeros(setup.dof)

    def join(self, user: int, position: Array) -> None:
        """Begin a contact without force."""
        self.contacts[user].attach(position - self.position)
        self.at[user] = position

    def leave(self, user: int) -> None:
        """End a contact; what its spring held is lost."""
        self.contacts[user].detach()
        del self.at[user]

    @property
    def energy(self) -> Value:
        """Energy of the springs [J]."""
        total: Value = np.zeros(1)
        for user in self.at:
            total = total + self.contacts[user].energy
        return total


class TouchedWall(Touched):
    """Stands still; every user has its own side or spring."""

    def step(self, position: Array, velocity: Array, dt: float) -> Array:
        """Return the forces at the end of the step."""
        shift = self._go(dt)
        force = np.zeros_like(position)
        for user, before in self.at.items():
            contact = self.contacts[user]
            contact.slide(position[user] - before - shift)
            self.at[user] = position[user]
            force[user] = contact.force(velocity[user] - self.velocity)
        return force

    def _go(self, dt: float) -> Value:
        """Move the wall; return by how much [m]."""
        return 0.0


class SlopedWall(TouchedWall):
    """The wall that also reports the slope of its force: the loop is solved (App. C Eq. 4)."""

    def local(self, position: Array, dt: float) -> tuple[Array, Array]:
        """Return the force without motion, and K dt + B where there is contact."""
        force, slope = np.zeros_like(position), np.zeros_like(position)
        for user, before in self.at.items():
            contact = copy.deepcopy(self.contacts[user])
            contact.slide(position[user] - before)
            force[user] = contact.force(0.0 * before)
            rise = contact.force(0.0 * before + 1.0)
            touching = contact.touching
            slope[user] = where(touching, rise - force[user] + contact.stiffness * dt, 0.0)
        return force, slope


class ActiveWall(TouchedWall):
    """A wall driven along axis 0, x = A sin(2 pi f t): it gives out what its drive puts in."""

    MEMORY = "_time_s"

    def __init__(self, setup: EnvironmentSetup) -> None:
        super().__init__(setup)
        drive = setup.server.active_wall
        self._amplitude, self._rate = drive.amplitude_m, 2.0 * np.pi * drive.frequency_hz
        self._along = np.eye(1, setup.dof)[0]
        self._time_s = 0.0

    def _go(self, dt: float) -> Value:
        """Follow the drive; the velocity is the mean over the step."""
        self._time_s += dt
        there: Array = self._amplitude * np.sin(self._rate * self._time_s) * self._along
        shift = there - self.position
        self.position, self.velocity = there, shift / dt
        return shift


class FreeCube(Touched):
    """The shared object: carried by whoever pushes it."""

    BLOCKS = "_body"

    def __init__(self, setup: EnvironmentSetup) -> None:
        super().__init__(setup)
        params = setup.server
        self._body = Cube(params.object_mass, params.object_damping, period=setup.period_s)
        self._body.x = self._body.xd = np.zeros(setup.dof)

    @property
    def energy(self) -> Value:
        """Energy of springs and motion [J]."""
        return super().energy + self._body.kinetic

    def step(self, position: Array, velocity: Array, dt: float) -> Array:
        """Return the mean forces over the step."""
        force = np.zeros_like(position)
        users = list(self.at)
        rates = {user: (position[user] - self.at[user]) / dt for user in users}

        def ask(mean: Value) -> list[tuple[Value, Answer]]:
            relative = [(user, rates[user] - mean) for user in users]
            return [(rate, self.contacts[user].meet(rate, dt)) for user, rate in relative]

        mean, answers = solve(ask, self._body)
        self._body.drift(mean)
        for user, answer in zip(users, answers, strict=True):
            self.contacts[user].advance(answer, dt)
            self.at[user] = position[user]
            force[user] = answer.force
        self.position, self.velocity = self._body.x, self._body.xd
        return force
