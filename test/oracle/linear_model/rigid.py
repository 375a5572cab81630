# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Motions that are no instability, and the transition matrix without them.

Where nothing holds the users to the ground, all may stand elsewhere (A t = t), and where nothing
brakes them either, all may move on uniformly (A t = t up to such a translation). These eigenvalues
are one exactly, and close by there may be others that matter; so they are not looked for, but
taken out, by an orthogonal basis of what is left.

With waves a device's position acts on nothing, and neither does the object's: each one is a
translation of its own, unless a position feedback ties a device to its avatar: then they move
together. The same holds for the deflection of a spring of no stiffness. A user without any contact
moves on for itself.

Equations: docs/theory.md 15.2.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from oracle.linear_model.blocks import column
from oracle.linear_model.loop import Line, Loop

from pmwvc_core.numeric import Array


class Family(NamedTuple):
    """A motion t with A t = t, once the families before it are taken out."""

    vector: Array  # (runs or 1, n), 1 at the pivot where the mask is set
    pivot: int
    mask: NDArray[np.bool_]  # (runs or 1,)


def families(loop: Loop) -> list[Family]:
    """Return the motions of a loop, translations first."""
    still = _free_positions(loop)
    return still + _drifting(loop)


def quotient(matrices: Array, found: list[Family]) -> Array:
    """Return the matrix ``(1, m, m)`` of the first run on what is orthogonal to its motions.

    They span a space that the matrix maps into itself, which is asserted; a basis that begins with
    that space makes the matrix block triangular.
    """
    matrix, own = matrices[0], [family.vector[0] for family in found if family.mask[0]]
    if not own:
        return matrices[:1]
    span = matrix @ matrix @ np.array(own).T  # also in states that nothing reads
    basis, _ = np.linalg.qr(span, mode="complete")
    within, across = np.split(basis, [len(own)], axis=1)
    assert np.abs(across.T @ matrix @ within).max(initial=0.0) < 1e-9 * np.abs(matrix).max()
    return (across.T @ matrix @ across)[np.newaxis]


def count(found: list[Family]) -> int:
    """Return how many motions the first run has."""
    return sum(bool(family.mask[0]) for family in found)


def _free_positions(loop: Loop) -> list[Family]:
    if not loop.server.waves:
        return _translations_without_waves(loop)
    zero, one = np.zeros((1, 1)), np.ones((1, 1))
    still, tied = [zero] * len(loop.lines), [_tied(line) for line in loop.lines]
    found = [
        _unit(loop, f"{line.name}.x", ~bound[:, 0])
        for line, bound in zip(loop.lines, tied, strict=True)
        if not bound.all()
    ]
    if loop.server.body.names:
        x: list[Array] = [np.where(bound, 1.0, 0.0) for bound in tied]
        vector = loop.motion(x, still, x_o=one, xd_o=zero)
        found.append(Family(vector, loop.names.index("x_o"), np.array([True])))
    for place, (line, seat) in enumerate(zip(loop.lines, loop.server.seats, strict=True)):
        loose = seat.stiffness[:, 0] == 0.0
        if loose.any():
            e = [one if other is line else zero for other in loop.lines]
            x = [np.where(bound, own, 0.0) for bound, own in zip(tied, e, strict=True)]
            vector = loop.motion(x, still, x_o=zero, xd_o=zero, e=e)
            found.append(Family(vector, loop.names.index(f"{line.name}.seat.e"), loose))
        found += _free_springs(loop, place)
    return found


def _tied(line: Line) -> NDArray[np.bool_]:
    """Tell, as a column, where a position feedback ties a device to its avatar."""
    feedback = line.port.feedback
    return feedback.gain > 0.0 if feedback else np.zeros((1, 1), dtype=np.bool_)


def _free_springs(loop: Loop, place: int) -> list[Family]:
    """Return the motion of a local model whose spring exerts nothing."""
    name = f"{loop.lines[place].name}.bank.local.x"
    if name not in loop.names:
        return []
    loose = column(loop.scenario.users[place].master.local_model.stiffness)[:, 0] == 0.0
    return [_unit(loop, name, loose)] if loose.any() else []


def _unit(loop: Loop, name: str, mask: NDArray[np.bool_]) -> Family:
    pivot = loop.names.index(name)
    return Family(np.eye(1, len(loop.names), pivot), pivot, mask)


def _translations_without_waves(loop: Loop) -> list[Family]:
    """Return the common translation, and those of users whose position acts on nothing."""
    zero, one = np.zeros((1, 1)), np.ones((1, 1))
    found = []
    loose = [seat.stiffness[:, 0] == 0.0 for seat in loop.server.seats]
    for place, line in enumerate(loop.lines):
        if loose[place].any():
            x = [one if other is line else zero for other in loop.lines]
            vector = loop.motion(x, [zero] * len(x), x_o=zero, xd_o=zero, e=x)
            found.append(Family(vector, loop.names.index(f"{line.name}.x"), loose[place]))
    if loop.server.body.names:
        users = len(loop.lines)
        vector = loop.motion([one] * users, [zero] * users, x_o=one, xd_o=zero)
        found.append(Family(vector, loop.names.index("x_o"), np.array([True])))
    return found


def _drifting(loop: Loop) -> list[Family]:
    """Return the uniform motions: of all that hang together, and of users by themselves.

    A virtual coupling pulls back what moves on: it gets the other end's position late.
    """
    if not all(line.port.drifts for line in loop.lines):
        return []
    zero, found = np.zeros((1, 1)), []
    users, seats = loop.scenario.users, loop.server.seats
    alone = [(seat.stiffness == 0.0) & (seat.damping == 0.0) for seat in seats]
    braked = [column(user.device.damping) > 0.0 for user in users]
    for place, line in enumerate(loop.lines):
        mask = alone[place] & ~braked[place] & ~_tied(line)
        if mask.any():
            one = np.ones((1, 1))
            xd = [one if other is line else zero for other in loop.lines]
            vector = loop.motion([zero] * len(xd), xd, x_o=zero, xd_o=zero)
            found.append(Family(vector, loop.names.index(f"{line.name}.xd"), mask[:, 0]))
    if loop.server.body.names and all(_steady_age(line) for line in loop.lines):
        found += _common_drift(loop, alone, braked)
    return found


def _common_drift(
    loop: Loop, alone: list[NDArray[np.bool_]], braked: list[NDArray[np.bool_]]
) -> list[Family]:
    """Return the uniform motion of the object with all users who touch it, where none is braked.

    The two ends of a wave link move as sqrt(b of the server / b of the master). A position
    feedback gets the avatar's position in steps: without force only where every tick has a packet.
    """
    mask = ~(column(loop.scenario.server.object_damping) > 0.0)
    x, xd = [], []
    for line, user, seat, off, brake in zip(
        loop.lines, loop.scenario.users, loop.server.seats, alone, braked, strict=True
    ):
        ratio = np.ones((1, 1))
        if loop.server.waves:
            ratio = np.sqrt(seat.b / column(user.master.impedance))
        tied = _tied(line)
        mask = mask & (off | ~brake) & (off | ~tied | (_steady_answers(line) & (ratio == 1.0)))
        xd.append(np.where(off, 0.0, 1.0) * ratio)
        if not loop.server.waves:
            x.append(xd[-1] * (line.ages()[0] * loop.tick_s))
        else:
            x.append(tied * xd[-1] * (line.received_at(0) * loop.tick_s))
    if not mask.any():
        return []
    one, serve = np.ones((1, 1)), loop.serve
    x_o = one * ((serve.phase - serve.period) * loop.tick_s)
    e = [np.where(off, -x_o, 0.0) for off in alone]  # an avatar by itself stays where it is
    vector = loop.motion(x, xd, x_o=x_o, xd_o=one, e=e)
    return [Family(vector, loop.names.index("xd_o"), mask[:, 0])]


def _steady_age(line: Line) -> bool:
    """Tell whether motion is reported equally late at every step: else the contact is stretched
    in turns, and there is no uniform motion without forces. Waves do not mind.
    """
    return line.port.signals == ("u",) or len(set(line.ages())) == 1


def _steady_answers(line: Line) -> bool:
    """Tell whether a position feedback gets the avatar's position equally late at every tick."""
    return line.answer.period == 1 and line.serve.period == 1
