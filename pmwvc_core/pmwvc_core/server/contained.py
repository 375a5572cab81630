# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Code from outside, contained: its answers are checked, and the failed steps of a coupling are a
matched damper at every port. Not here: a step that takes too long.
"""

from typing import Any, NamedTuple

import numpy as np

from pmwvc_core.law.motion import Body, BodyLaw, drifted, kinetic_j, mobility, pushed_body
from pmwvc_core.law.server.contacts import Avatar, contact_energy, couple, slid
from pmwvc_core.law.vectors import dot, minus, plus, scaled, within, zero
from pmwvc_core.law.wave.wave import free_velocity, wave_force, wave_velocity
from pmwvc_core.numeric import Array
from pmwvc_core.plugins import BadAnswer, Faults

LARGEST_N = 1e6  # more is no force
Step = tuple[tuple[Avatar, ...], Body, float, bool]


def signal(value: Any, shape: tuple[int, ...], name: str = "step") -> Array:
    """Return an answer of a call as an array of that shape; BadAnswer where it is none."""
    try:
        array = np.asarray(value)
        if np.iscomplexobj(array):
            raise BadAnswer(f"returned complex numbers from {name}")
        array = np.asarray(array, dtype=float)
    except (TypeError, ValueError):
        raise BadAnswer(f"returned {type(value).__name__} from {name}") from None
    if array.shape != shape:
        raise BadAnswer(f"returned shape {array.shape} from {name}, not {shape}")
    return array


class Contained(NamedTuple):
    """A coupling's own law, what went wrong, and how the damper in its place moves."""

    law: Any
    faults: Faults
    old_s: float  # weights of old and new velocity in an avatar's displacement
    new_s: float
    late: bool
    object_motion: str


@couple.member(Contained)
def contained(p: Contained, avatars: tuple[Avatar, ...], body: Body, law: BodyLaw) -> Step:
    """Step the coupling; for a step that it fails, f_s = sqrt(b/2) u_s, so that no wave returns.
    Avatars and object move by these forces as the record of the coupling says that they move; heat
    is what went in and is not stored.
    """

    def usable() -> Step:
        found: Step = couple(p.law, avatars, body, law)
        if all(within(plus(a.f, a.xd), LARGEST_N) for a in found[0] if a.present):
            return found
        raise BadAnswer("returned no usable force or velocity (not finite, or beyond 1e6)")

    if (found := p.faults.guarded(usable, None)) is not None:
        return found
    p.faults.replaced = True
    before_j, into_j = _stored_j(avatars, body, law), 0.0
    force, held, ways, moved = zero(body.x), zero(body.x), [], []
    for a in avatars:
        damped = scaled(free_velocity(a.impedance, a.u), 0.5)
        push = wave_force(a.impedance, damped, zero(damped))
        xd = wave_velocity(a.impedance, a.u, a.f) if p.late else damped
        if a.present:
            into_j += law.period_s * dot(push, xd)
            force, held = plus(force, push), plus(held, a.f)
        ways.append(plus(scaled(a.xd, p.old_s), scaled(xd, p.new_s)))
        moved.append(a._replace(xd=xd, f=push))
    if p.object_motion != "midpoint":
        pushes = held if p.object_motion == "held_before" else force
        body, shift, _ = pushed_body(body, pushes, law)
    else:
        mobile, pushed = mobility(0.0, law), plus(scaled(body.xd, law.inertance), force)
        mean = scaled(pushed, mobile) if mobile else zero(force)
        body, _ = drifted(body, mean, law)
        shift = scaled(mean, law.period_s)
    after = tuple(
        a._replace(contact=slid(a.contact, minus(way, shift))[0]) if a.present else before
        for a, way, before in zip(moved, ways, avatars, strict=True)
    )
    return after, body, into_j - (_stored_j(after, body, law) - before_j), True


def _stored_j(avatars: tuple[Avatar, ...], body: Body, law: BodyLaw) -> float:
    springs = sum(contact_energy(a.contact) for a in avatars if a.present)
    return kinetic_j(body, law) + springs
