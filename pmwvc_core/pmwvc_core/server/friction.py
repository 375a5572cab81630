# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The one-sided contact in several axes: a grip along axis 0, an anchored spring across it.

The anchor is set where contact begins. During a step the anchor holds if the avatar was inside at
its start; it is let go at the end of the step in which the avatar comes out, and the energy of its
spring is dropped (it heats). There is no sliding: gripped things do not slip.

Not here: the law along axis 0 (``grip``).
"""

import numpy as np

from pmwvc_core.numeric import Array, Flag, Value, where
from pmwvc_core.server.contacts import Answer, Bilateral
from pmwvc_core.server.grip import Grip
from pmwvc_core.state import Stateful


def _normal(value: Value) -> Value:
    return value[..., :1] if isinstance(value, np.ndarray) else value


def _across(value: Value) -> Value:
    return value[..., 1:] if isinstance(value, np.ndarray) else value


class AnchoredGrip(Stateful):
    """A grip along axis 0 whose avatar also holds on sideways; arrays ``(..., dof)`` only."""

    BLOCKS = "grip anchor"

    def __init__(self, grip: Grip, *, dof: int) -> None:
        self.grip = grip
        self.anchor = Bilateral(grip.stiffness, grip.damping)
        self.anchor.deflection = self.anchor.rest = np.zeros(dof - 1)
        self.stiffness = grip.stiffness
        self.damping = grip.damping
        self._dof = dof

    def _join(self, normal: Value, across: Value) -> Array:
        """Put the axes together again."""
        shape = np.broadcast_shapes(np.shape(normal)[:-1], np.shape(across)[:-1])
        return np.concatenate(
            [
                np.broadcast_to(normal, (*shape, 1)),
                np.broadcast_to(across, (*shape, self._dof - 1)),
            ],
            axis=-1,
        )

    @property
    def deflection(self) -> Value:
        """Deflection of both springs [m]."""
        return self._join(self.grip.deflection, self.anchor.deflection)

    @property
    def position(self) -> Value:
        """Position of the avatar, from the object's centre [m]."""
        return self._join(self.grip.position, self.anchor.position)

    @property
    def touching(self) -> Flag:
        """True where the avatar is inside the face."""
        return self.grip.touching

    @property
    def energy(self) -> Value:
        """Energy of both springs [J]."""
        return self.grip.energy + self.anchor.energy

    def attach(self, offset: Value) -> None:
        """Begin outside the face, with nothing to hold on to."""
        self.grip.attach(_normal(offset))
        self.anchor.attach(_across(offset))

    def detach(self) -> Value:
        """Let go; return the energy dropped."""
        return self.grip.detach() + self.anchor.detach()

    def configure(self, stiffness: Value, damping: Value) -> Value:
        """Keep energies and position; return what is lost."""
        self.stiffness, self.damping = stiffness, damping
        lost = self.grip.configure(stiffness, damping)
        return lost + self.anchor.configure(stiffness, damping)

    def force(self, rate: Value) -> Value:
        """Return normal and holding force."""
        held = where(self.touching, self.anchor.force(_across(rate)), 0.0)
        return self._join(self.grip.force(_normal(rate)), held)

    def heat(self, rate: Value) -> Value:
        """Return the power both dampers turn into heat."""
        held = where(self.touching, self.anchor.heat(_across(rate)), 0.0)
        return self.grip.heat(_normal(rate)) + held

    def unwrapped(self, free: Value, xd_o: Value, impedance: Value, weight: Value) -> Value:
        """Solve each axis by itself; the anchor holds where contact was before."""
        across = self.anchor.unwrapped(_across(free), _across(xd_o), impedance, weight)
        normal = self.grip.unwrapped(_normal(free), _normal(xd_o), impedance, weight)
        return self._join(normal, where(self.touching, across, 0.0))

    def slide(self, displacement: Value) -> Value:
        """Move; return the energy dropped where the avatar came out."""
        held = self.touching
        self.grip.slide(_normal(displacement))
        return self._drag(held, _across(displacement))

    def clear(self, displacement: Value) -> Value:
        """Return its part along axis 0, as far as there is no contact."""
        return self._join(self.grip.clear(_normal(displacement)), 0.0 * _across(displacement))

    def answer(self, free: Value, impedance: Value, period: Value) -> Answer:
        """Solve each axis by itself; the anchor holds where the step begins inside."""
        held = self.touching
        normal = self.grip.answer(_normal(free), impedance, period)
        across = self.anchor.answer(_across(free), impedance, period)
        return Answer(
            self._join(normal.force, where(held, across.force, 0.0)),
            self._join(normal.rate, where(held, across.rate, _across(free))),
            self._join(normal.slope, where(held, across.slope, 0.0)),
        )

    def meet(self, rate: Value, period: Value) -> Answer:
        """Meet each axis by itself; the anchor holds where the step begins inside."""
        held = self.touching
        normal = self.grip.meet(_normal(rate), period)
        across = self.anchor.meet(_across(rate), period)
        return Answer(
            self._join(normal.force, where(held, across.force, 0.0)),
            rate,
            self._join(normal.slope, where(held, across.slope, 0.0)),
        )

    def advance(self, answer: Answer, period: Value) -> Value:
        """Move by an answer; return what became heat or was dropped."""
        held = self.touching
        rate = _across(answer.rate)
        heat = where(held, period * self.anchor.heat(rate), 0.0)
        normal = Answer(_normal(answer.force), _normal(answer.rate), _normal(answer.slope))
        heat = heat + self.grip.advance(normal, period)
        return heat + self._drag(held, period * rate)

    def _drag(self, held: Flag, displacement: Value) -> Value:
        """Stretch the anchored spring or carry a loose anchor; return the energy dropped."""
        anchor = self.anchor
        anchor.deflection = anchor.deflection + where(held, displacement, 0.0)
        anchor.rest = anchor.rest + where(held, 0.0, displacement)
        loose = self.touching
        loose = ~loose if isinstance(loose, np.ndarray) else not loose
        dropped = where(loose, anchor.energy, 0.0)
        anchor.rest = anchor.rest + where(loose, anchor.deflection, 0.0)
        anchor.deflection = where(loose, 0.0, anchor.deflection)
        return dropped
