# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The ratios of a force that the safety limits let through: soft start, damping, release.

The whole force rises over ``soft_start_s`` and falls over ``LET_GO_S`` on release. While only
damping is rendered, what does not oppose the motion fades over ``FADE_S``; afterwards the force
goes on from what had not faded. After a silence of the same server it rises within ``RETURN_S``
(with a brake it is whole at once).
"""

from typing import NamedTuple

from pmwvc_core.law.vectors import Vector, dot, minus, plus, scaled, squared, zero

FADE_S, LET_GO_S = 0.02, 0.5
RETURN_S = 0.1  # after a silence of the same server: meanwhile the hand runs ahead


class Fading(NamedTuple):
    """What is let through: of the whole force, and of what pushes while only damping is."""

    gain: float
    push: float
    ready: bool  # the force has been let through in full
    damped: bool  # in the tick before
    returns: bool  # rises after a silence of the same server
    quiet: bool  # the tick before saw a silence and nothing else


class Through(NamedTuple):
    """What is let through in a tick: a force at all; only damping; since it is too fast, so that
    what pushes goes at once; since the server is silent; not even that any more.
    """

    force: bool
    damped: bool
    fast: bool
    outside: bool
    silent: bool
    released: bool


RESTING_FADING = Fading(0.0, 1.0, False, False, False, False)


def faded(s: Fading, x: Through, soft_start_s: float, tick_s: float, whole: bool) -> Fading:
    """Go one tick on; ``whole``: the force comes back whole after a silence, as a brake holds the
    hand meanwhile.
    """
    recovers = s.damped and not x.damped
    quiet = s.quiet and s.ready
    returns = (quiet if recovers else s.returns) and x.force
    gain = s.gain
    if recovers and not (quiet and whole):
        gain *= s.push
    if x.released:
        gain = max(gain - tick_s / LET_GO_S, 0.0)
    else:
        rise_s = min(soft_start_s, RETURN_S) if returns else soft_start_s
        gain = min(gain + tick_s / rise_s, 1.0)
    if not x.force:
        gain = 0.0
    ready = s.ready or (gain >= 1.0 and not x.damped)
    push = 1.0
    if x.damped:
        push = 0.0 if x.fast else max(s.push - tick_s / FADE_S, 0.0)
    alone = x.silent and not (x.fast or x.outside)
    return Fading(gain, push, ready, x.damped, returns, alone)


def damping(f: Vector, xd: Vector, push: float) -> Vector:
    """Return the part of a force [N] that opposes the motion, and what is left of the rest."""
    power, speed = dot(f, xd), squared(xd)
    kept = scaled(xd, power / speed) if power > 0.0 and speed > 0.0 else zero(f)
    return plus(kept, scaled(minus(f, kept), push))
