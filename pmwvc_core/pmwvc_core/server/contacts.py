# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Contact between one avatar and the object: what every law offers, and the two-sided one.

A contact knows the deflection of its spring and the position at which that spring is at rest,
relative to the object, so the avatar stands at ``x_s = x_o + position`` with ``position = rest +
deflection``. The deflection is the state (never the difference of two positions, which would lose
digits far from the origin). Forces act from the avatar on the object.

Stiffness and damping may change while the contact is made: the deflection then becomes
sqrt(K_old/K_new) times what it was, so that the spring stores what it stored; the avatar stays
where it is, and its spring is at rest elsewhere (a stiffness that rises as it is adds energy, a
position that jumps is felt).

Not here: waves, the object, and how force and motion are solved for (``couplings``).

Equations: docs/theory.md 4.1, 4.10.
"""

from dataclasses import dataclass
from typing import Protocol

from pmwvc_core.account import Passage
from pmwvc_core.numeric import Flag, Value, root, squared, where
from pmwvc_core.state import Stateful

# Heat of the dampers: what the server counted, springs let go included, less that of the object.
CONTACTS = Passage("integration", ("avatars",), ("object",), ("springs",), ("dampers",))


@dataclass(slots=True)
class Answer:
    """The answer of a contact to the relative velocity its avatar would have without it."""

    force: Value  # (..., dof) [N] on the object
    rate: Value  # (..., dof) [m/s] relative velocity, mean over the step
    slope: Value  # (..., dof) [N s/m] by how much the force falls per velocity of the object


class Contact(Protocol):
    """One avatar's contact; the methods below ``energy`` come in two families.

    Sampled (couplings that use the force at an instant): ``force``, ``heat``, ``unwrapped``, moved
    by ``slide``. Mean over a step (implicit coupling): ``answer``, ``meet``, moved by ``advance``.
    """

    @property
    def stiffness(self) -> Value:
        """K [N/m]."""
        ...

    @property
    def deflection(self) -> Value:
        """Avatar minus object minus rest [m]."""
        ...

    @property
    def position(self) -> Value:
        """Position of the avatar, from the object's centre [m]."""
        ...

    @property
    def touching(self) -> Flag:
        """True where a force can act."""
        ...

    @property
    def energy(self) -> Value:
        """Energy of the spring [J]."""
        ...

    def attach(self, offset: Value) -> None:
        """Begin at ``offset`` = avatar minus object [m], without force."""
        ...

    def detach(self) -> Value:
        """End the contact; return the energy of the spring, which is dropped [J]."""
        ...

    def configure(self, stiffness: Value, damping: Value) -> Value:
        """Take other parameters over; return the energy that the spring loses [J]: none, but
        where there is no spring any more.
        """
        ...

    def force(self, rate: Value) -> Value:
        """Return the force [N] at the present deflection and a relative velocity [m/s]."""
        ...

    def heat(self, rate: Value) -> Value:
        """Return the power [W] the damper turns into heat at a relative velocity [m/s]."""
        ...

    def unwrapped(self, free: Value, xd_o: Value, impedance: Value, weight: Value) -> Value:
        """Return the force [N] that fits xd = free - f/impedance and a move of weight xd."""
        ...

    def slide(self, displacement: Value) -> Value:
        """Move the avatar relative to the object [m]; return the energy dropped [J]."""
        ...

    def clear(self, displacement: Value) -> Value:
        """Return the part of a displacement [m] that leads to no contact; zero in contact."""
        ...

    def answer(self, free: Value, impedance: Value, period: Value) -> Answer:
        """Return the mean force over a step for which rate = free - force/impedance."""
        ...

    def meet(self, rate: Value, period: Value) -> Answer:
        """Return the mean force over a step with a given mean relative velocity."""
        ...

    def advance(self, answer: Answer, period: Value) -> Value:
        """Move by an answer; return the energy turned into heat [J]."""
        ...


def kept(deflection: Value, old: Value, new: Value) -> Value:
    """Return the deflection [m] at which a spring of stiffness ``new`` stores what one of ``old``
    [N/m] does; unchanged where it can store nothing.
    """
    return deflection * root(where(new > 0.0, old, 1.0) / where(new > 0.0, new, 1.0))


class Bilateral(Stateful):
    """Spring and damper that push and pull along every axis: f = K e + B e'.

    Used in the stability analysis (App. B, Eq. 3). The spring is at rest where the avatar stood
    when it joined.
    """

    SIGNALS = "deflection"
    MEMORY = "rest"
    touching: Flag = True

    def __init__(self, stiffness: Value, damping: Value) -> None:
        self.stiffness = stiffness  # [N/m]
        self.damping = damping  # [N s/m]
        self.deflection: Value = 0.0  # (..., dof) [m]
        self.rest: Value = 0.0  # (..., dof) [m]

    @property
    def position(self) -> Value:
        """Position of the avatar, from the object's centre [m]."""
        return self.rest + self.deflection

    @property
    def energy(self) -> Value:
        """Energy of the spring, K |e|^2 / 2 [J]."""
        return 0.5 * self.stiffness * squared(self.deflection)

    def attach(self, offset: Value) -> None:
        """Begin without force: the spring rests at the present distance."""
        self.rest = offset
        self.deflection = 0.0 * offset

    def detach(self) -> Value:
        """Let go; return the energy dropped."""
        dropped = self.energy
        self.rest = self.position
        self.deflection = 0.0 * self.deflection
        return dropped

    def configure(self, stiffness: Value, damping: Value) -> Value:
        """Keep energy and position; return what is lost."""
        before, stood = self.energy, self.position
        self.deflection = kept(self.deflection, self.stiffness, stiffness)
        self.rest = stood - self.deflection
        self.stiffness, self.damping = stiffness, damping
        return before * where(stiffness > 0.0, 0.0, 1.0)

    def force(self, rate: Value) -> Value:
        """Return K e + B e'."""
        return self.stiffness * self.deflection + self.damping * rate

    def heat(self, rate: Value) -> Value:
        """Return B |e'|^2."""
        return self.damping * squared(rate)

    def unwrapped(self, free: Value, xd_o: Value, impedance: Value, weight: Value) -> Value:
        """Solve f = K (e + weight xd) + B (xd - xd_o), xd = free - f/impedance (App. C, Eq. 4)."""
        gain = self.damping + weight * self.stiffness
        loose = self.stiffness * self.deflection + gain * free - self.damping * xd_o
        return loose / (1.0 + gain / impedance)

    def slide(self, displacement: Value) -> Value:
        """Stretch the spring; nothing is dropped."""
        self.deflection = self.deflection + displacement
        return 0.0

    def clear(self, displacement: Value) -> Value:
        """Return zero: it is always in contact."""
        return 0.0 * displacement

    def answer(self, free: Value, impedance: Value, period: Value) -> Answer:
        """Solve f = K (e + h w/2) + B w with w = free - f/impedance (midpoint: exact energy)."""
        gain = 0.5 * self.stiffness * period + self.damping
        ratio = 1.0 + gain / impedance
        pull = self.stiffness * self.deflection
        rate = (free - pull / impedance) / ratio
        return Answer((pull + gain * free) / ratio, rate, gain / ratio)

    def meet(self, rate: Value, period: Value) -> Answer:
        """Return K (e + h w/2) + B w."""
        gain = 0.5 * self.stiffness * period + self.damping
        return Answer(self.stiffness * self.deflection + gain * rate, rate, gain)

    def advance(self, answer: Answer, period: Value) -> Value:
        """Stretch the spring by the mean rate; return h B |w|^2."""
        self.deflection = self.deflection + period * answer.rate
        return period * self.damping * squared(answer.rate)
