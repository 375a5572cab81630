# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Contact between one avatar and the object: two-sided, or a grip with an anchored spring across.

The avatar stands at ``x_s = x_o + rest + deflection``. Forces act from it on the object; those
along an axis are of :mod:`.springs`. Two-sided it is at rest where the avatar joined. A grip
pushes along axis 0 only; across it an anchor is set where contact begins and let go at the end of
the step in which the avatar comes out, where its spring energy is dropped.

When stiffness and damping change in contact, the deflection becomes sqrt(K_old/K_new) times what
it was, so that the spring stores what it stored; the face of a grip counts as shifted, and returns
outside the contact. A coupling closes the algebraic loop of a step: from the waves u of all
avatars it finds velocities and contact forces, and moves avatars and object. Equations:
docs/theory.md 4.10.
"""

import math
from typing import Any, NamedTuple

from pmwvc_core.law.family import Family
from pmwvc_core.law.server.springs import ContactLaw, Spring, depth, force_at, stored
from pmwvc_core.law.vectors import Vector, columns, each, plus, scaled, total, zero


class Contact(NamedTuple):
    """The contact of an avatar."""

    law: ContactLaw
    springs: tuple[Spring, ...]  # per axis


def touching(c: Contact) -> bool:
    """Tell whether a force can act."""
    return not c.springs[0].one_sided or depth(c.springs[0], c.law) > 0.0


def offset_of(c: Contact) -> Vector:
    """Return the position of the avatar, from the object's centre [m]."""
    deflection, rest, _ = columns(c.springs)
    return plus(rest, deflection)


def contact_energy(c: Contact) -> float:
    """Return the energy of the springs [J]."""
    return total(0.0, each(stored, (c.springs,), c.law))


def attached(c: Contact, offset: Vector) -> Contact:
    """Begin at avatar minus object [m], without force: a grip at least the gap outside."""
    return c._replace(springs=each(_attached, (c.springs, offset), c.law))


def _attached(s: Spring, offset: float, law: ContactLaw) -> Spring:
    if s.one_sided:
        outside = min(law.inward * (offset - law.face), -law.gap)
        return Spring(law.inward * outside, law.face, True)
    return Spring(0.0, offset, False)


def detached(c: Contact) -> tuple[Contact, float]:
    """End the contact; return the energy of the springs, which is dropped [J]."""
    return c._replace(springs=each(_detached, (c.springs,), c.law)), contact_energy(c)


def _detached(s: Spring, law: ContactLaw) -> Spring:
    if s.one_sided:
        return s._replace(deflection=law.inward * min(depth(s, law), 0.0), one_sided=True)
    return Spring(0.0, s.rest + s.deflection, False)


def changed_contact(c: Contact, stiffness: float, damping: float) -> tuple[Contact, float]:
    """Take K and B over; return the energy lost [J]: none, but where there is no spring now."""
    old = c.law
    law = old._replace(stiffness=stiffness, damping=damping)
    lost_j = 0.0 if stiffness > 0.0 else contact_energy(c)
    return Contact(law, each(_changed, (c.springs,), old, law)), lost_j


def _changed(s: Spring, old: ContactLaw, new: ContactLaw) -> Spring:
    ratio = math.sqrt(old.stiffness / new.stiffness) if new.stiffness > 0.0 else 1.0
    if s.one_sided and depth(s, old) <= 0.0:
        ratio = 1.0
    if ratio == 1.0:  # to the last bit
        return s
    deflection = s.deflection * ratio
    changed = Spring(deflection, s.rest + s.deflection - deflection, s.one_sided)
    return _returned(changed, new) if s.one_sided else changed


def _returned(s: Spring, law: ContactLaw) -> Spring:
    """Shift the face back where it is not touched, at most to the avatar."""
    if s.rest == law.face:
        return s
    inside = depth(s, law)
    shift = law.inward * (s.rest - law.face)
    back = 0.0 if inside > 0.0 else min(shift, -inside)
    left = 0.0 if back == shift else shift - back
    deflection = s.deflection + law.inward * back
    return Spring(deflection, law.face + law.inward * left, True)


def contact_force(c: Contact, rate: Vector) -> Vector:
    """Return the force on the object [N] at a relative velocity [m/s]."""
    return each(force_at, (c.springs, rate), touching(c), c.law)


def contact_heat(c: Contact, rate: Vector) -> float:
    """Return the power [W] that the damper turns into heat at a relative velocity [m/s]."""
    heat_w, held, law = 0.0, touching(c), c.law
    for i in range(len(rate)):
        s = c.springs[i]
        acts = law.inward * force_at(s, rate[i], held, law) > 0.0 if s.one_sided else held
        if acts:
            heat_w += law.damping * rate[i] * rate[i]
    return heat_w


def advanced_contact(c: Contact, force: Vector, rate: Vector, h: float) -> tuple[Contact, float]:
    """Move by the mean velocity of a step of h [s] with the mean force; return the heat [J]."""
    held, law, heat_j = touching(c), c.law, 0.0
    springs = each(_moved, (c.springs, scaled(rate, h)), held, law)
    for i in range(len(rate)):
        s, after = c.springs[i], springs[i]
        if not s.one_sided:
            heat_j += h * law.damping * rate[i] * rate[i] if held else 0.0
        elif law.inward * force[i] > 0.0:
            p0 = depth(s, law)
            way_inside = max(p0 + law.inward * (h * rate[i]), 0.0) - max(p0, 0.0)
            heat_j += law.damping * way_inside * (law.inward * rate[i])
        else:
            heat_j += stored(s, law) - stored(after, law)
    moved, dropped_j = _loosened(Contact(law, springs))
    return moved, heat_j + dropped_j


def slid(c: Contact, displacement: Vector) -> tuple[Contact, float]:
    """Move the avatar relative to the object [m]; return the energy dropped where it came out."""
    springs = each(_moved, (c.springs, displacement), touching(c), c.law)
    return _loosened(c._replace(springs=springs))


def _moved(s: Spring, way: float, held: bool, law: ContactLaw) -> Spring:
    if s.one_sided:
        return _returned(s._replace(deflection=s.deflection + way, one_sided=True), law)
    if held:
        return Spring(s.deflection + way, s.rest, False)
    return Spring(s.deflection, s.rest + way, False)


def _loosened(c: Contact) -> tuple[Contact, float]:
    """Let the anchor go where the avatar is outside; return the energy of its spring [J]."""
    if touching(c):
        return c, 0.0
    return detached(c)


def cleared(c: Contact, displacement: Vector) -> Vector:
    """Return the part of a way [m] to the gap before the face; zero in contact, and across."""
    if touching(c):
        return zero(displacement)
    return each(_cleared, (c.springs, displacement), c.law)


def _cleared(s: Spring, way: float, law: ContactLaw) -> float:
    if not s.one_sided:
        return 0.0
    return law.inward * min(law.inward * way, max(-depth(s, law) - law.gap, 0.0))


couple = Family("couple")  # (p, avatars, body, law) -> (avatars, body, lost_j, settled)


class Avatar(NamedTuple):
    """One avatar: its port, signals of the last step, contact."""

    present: bool
    impedance: Any  # of the wave port; behind its brake while that acts
    u: Vector  # [sqrt(W)] of this step
    xd: Vector  # [m/s]
    f: Vector  # [N] on the object
    contact: Contact
    kept: Vector  # what a coupling keeps for its next step


def springs_j(avatars: tuple[Avatar, ...]) -> float:
    """Return the energy of all contact springs [J]."""
    return total(0.0, each(_spring_j, (avatars,)))


def _spring_j(a: Avatar) -> float:
    return contact_energy(a.contact)  # of one who is not there: none
