# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The spring and damper of a contact along one axis, and its force on the object.

Two-sided (App. B, Eq. 3): f = K e + B e', of which ``held`` tells whether it acts. The face of a
grip pushes only (:mod:`.grip`).

Equations: docs/theory.md 4.1.
"""

from typing import NamedTuple

from pmwvc_core.law.server.grip import Answer, met, pushed, sampled, unwrapped


class ContactLaw(NamedTuple):
    """K [N/m], B [N s/m]; of a grip the inward direction (1 or -1), where its face is, from the
    centre of the object [m], and the least distance from it at the start [m].
    """

    stiffness: float
    damping: float
    inward: float
    face: float
    gap: float


class Spring(NamedTuple):
    """A contact along one axis [m]."""

    deflection: float
    rest: float
    one_sided: bool  # of a grip, along axis 0
    shifted: bool  # its face


def depth(s: Spring, law: ContactLaw) -> float:
    """Return how deep an avatar is in the face; negative outside [m]."""
    return law.inward * s.deflection


def stored(s: Spring, law: ContactLaw) -> float:
    """Return the energy of the spring along an axis [J]: K e^2/2, of a grip while it is inside."""
    inside = max(depth(s, law), 0.0) if s.one_sided else s.deflection
    return 0.5 * law.stiffness * inside * inside


def spring_force(s: Spring, rate: float, held: bool, law: ContactLaw) -> float:
    """Return the force [N] at the present deflection and a relative velocity [m/s]."""
    if s.one_sided:
        inward = law.inward
        return inward * sampled(depth(s, law), inward * rate, law.stiffness, law.damping)
    return law.stiffness * s.deflection + law.damping * rate if held else 0.0


def unwrapped_axis(
    s: Spring, free: float, xd_o: float, b: float, weight: float, held: bool, law: ContactLaw
) -> float:
    """Return the force along an axis [N], as above."""
    gain = law.damping + weight * law.stiffness
    loose = law.stiffness * s.deflection + gain * free - law.damping * xd_o
    if s.one_sided:
        c, inward = law.inward * free, law.inward
        return inward * unwrapped(depth(s, law), c, inward * loose, gain, b, weight)
    return loose / (1.0 + gain / b) if held else 0.0


def spring_answer(
    s: Spring, free: float, b: float, h: float, held: bool, law: ContactLaw
) -> Answer:
    """Return the mean force over a step of h [s] for which rate = free - force/b."""
    if s.one_sided:
        inward, p0 = law.inward, depth(s, law)
        push = pushed(p0, inward * free, law.stiffness, law.damping, b, h)
        return Answer(inward * push.force, inward * push.rate, push.slope)
    if not held:
        return Answer(0.0, free, 0.0)
    gain = 0.5 * law.stiffness * h + law.damping
    ratio = 1.0 + gain / b
    pull = law.stiffness * s.deflection
    return Answer((pull + gain * free) / ratio, (free - pull / b) / ratio, gain / ratio)


def spring_meets(s: Spring, rate: float, h: float, held: bool, law: ContactLaw) -> Answer:
    """Return the mean force over a step of h [s] with a given mean relative velocity."""
    if s.one_sided:
        push = met(depth(s, law), law.inward * rate, law.stiffness, law.damping, h)
        return Answer(law.inward * push.force, rate, push.slope)
    if not held:
        return Answer(0.0, rate, 0.0)
    gain = 0.5 * law.stiffness * h + law.damping
    return Answer(law.stiffness * s.deflection + gain * rate, rate, gain)
