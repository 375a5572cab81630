# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Motions that are no instability, and the transition matrix without them.

Where nothing holds the users to the ground, all may stand elsewhere (A t = t), and where nothing
brakes them either, all may move on uniformly (A t = t up to such a translation). These eigenvalues
are one exactly, and close by there may be others that matter; so they are not looked for, but
taken out. With t scaled to 1 at a pivot j, z' = z - t z_j has no more of t in it, and its matrix

    A'[i, k] = A[i, k] - t_i A[j, k]        (row and column j become zero)

has the eigenvalues of A less one that was 1, and a zero in its place. In a batch every run has its
own motions; ``mask`` marks the runs that have a given one.

With waves a device's position acts on nothing, and neither does the object's: each one is a
translation of its own, unless a position feedback ties a device to its avatar: then they move
together. The same holds for the deflection of a spring of no stiffness. A user without any contact
moves on for itself.

Equations: docs/theory.md 15.2.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pmwvc_analysis.models.links import Line
from pmwvc_core.controllers.library import record_of
from pmwvc_core.numeric import Array, Flags, Value, root
from pmwvc_core.wave.impedance import Impedance, MatrixImpedance

if TYPE_CHECKING:
    from pmwvc_analysis.models.linearize import Linear

ROUNDING_S = 1e-12  # of a lag that does not change
Signals = dict[str, Array]  # of signals by name, a row or one per run, along each axis


class Motion(NamedTuple):
    """A motion by what moves in it; see :attr:`.linearize.Linear.placed`."""

    pivot: str
    axis: int
    mask: Flags  # (runs or 1,): which runs have it
    position: Signals  # where it begins, else zero; there of velocities their value
    velocity: Signals  # how fast positions change, else they stay


class Family(NamedTuple):
    """A motion t with A t = t, once the families before it are taken out."""

    vector: Array  # (runs, n), 1 at the pivot where the mask is set
    pivot: int
    mask: Flags  # (runs or 1,)


class Freedom(NamedTuple):
    """What of a user's line decides which motions it leaves free, a row per run ``(runs or 1, 1)``
    each.
    """

    loose: Flags  # no spring in the contact
    alone: Flags  # nothing in the contact that exerts a force
    tied: Flags  # the device goes where its avatar does: by a position feedback, or without waves
    braked: Flags  # the device is damped


def freedom_of(line: Line) -> Freedom:
    """Return the freedom of a user's line."""
    contact, position = line.user.contact, line.user.master.position
    loose = per_run(contact.contact_stiffness) == 0.0
    gain = position.gain if position.is_on else 0.0
    return Freedom(
        loose,
        loose & (per_run(contact.contact_damping) == 0.0),
        per_run(gain if line.waves else 1.0) > 0.0,
        per_run(line.user.device.damping) > 0.0,
    )


def per_run(value: Value) -> Array:
    """Return a number, or one per run, as a row per run."""
    return np.asarray(value, dtype=float).reshape(-1, 1)


def motions(linear: "Linear") -> list[Motion]:
    """Return the motions of a loop, translations first."""
    loop = linear.loop
    found = [motion for axis in range(loop.dof) for motion in _translations(linear, axis)]
    if record_of(loop.scenario.controller).drifts:
        found += [motion for axis in range(loop.dof) for motion in _drifting(linear, axis)]
    return found


def families(linear: "Linear") -> list[Family]:
    """Return the motions of a loop as vectors of its states.

    Devices, object, deflections and springs are as given above; all other states follow from z(n)
    = z0 + n z1, z(n+1) = A z(n).
    """
    loop, n, found = linear.loop, len(linear.columns), motions(linear)
    matrices, period_s = linear.matrices, loop.ticks * loop.tick_s
    now, change = np.zeros((2, len(matrices), n, len(found)))
    given = np.zeros(n, dtype=np.bool_)
    for (name, axis), column in linear.columns.items():
        given[column] = name in linear.placed
        for index, motion in enumerate(found):
            if name in motion.position:
                now[:, column, index] = motion.position[name][:, axis]
            if name in motion.velocity:
                change[:, column, index] = motion.velocity[name][:, axis] * period_s
    p, s = np.flatnonzero(given), np.flatnonzero(~given)
    if len(s) and found:
        moves = matrices - np.eye(n)  # (A - I) z1 = 0, (A - I) z0 = z1, both consistent
        orthogonal, upper = np.linalg.qr(moves[..., s])
        across = orthogonal.swapaxes(-1, -2)
        change[:, s] = np.linalg.solve(upper, -across @ (moves[..., p] @ change[:, p]))
        now[:, s] = np.linalg.solve(upper, across @ (change - moves[..., p] @ now[:, p]))
    return [
        Family(now[..., index], linear.columns[motion.pivot, motion.axis], motion.mask)
        for index, motion in enumerate(found)
    ]


def quotient(matrices: Array, found: list[Family]) -> Array:
    """Return the matrices ``(runs, m, m)``, m <= n, on the quotient by motions.

    A motion that some runs have and others do not leaves a zero eigenvalue behind.
    """
    matrices = matrices.copy()
    zero = np.zeros(matrices.shape[:2])
    vectors = [np.where(family.mask[:, np.newaxis], family.vector, zero) for family in found]
    for index, (t, (_, j, mask)) in enumerate(zip(vectors, found, strict=True)):
        matrices -= t[:, :, np.newaxis] * matrices[:, j : j + 1, :]
        of = np.broadcast_to(mask, len(matrices))
        matrices[of, j, :] = matrices[of, :, j] = 0.0
        for other in vectors[index + 1 :]:
            other -= t * other[:, j : j + 1]
    gone = [family.pivot for family in found if family.mask.all()]
    left = np.setdiff1d(np.arange(matrices.shape[-1]), gone)
    return matrices[:, left[:, np.newaxis], left]


def count(found: Sequence[Family | Motion]) -> int:
    """Return how many motions the first run has."""
    return sum(bool(each.mask[0]) for each in found)


def _translations(linear: "Linear", axis: int) -> list[Motion]:
    """Return the translations: of devices, of the object, and of springs that exert nothing, in
    contacts and local models.
    """
    loop, one = linear.loop, np.eye(linear.loop.dof)[axis : axis + 1]
    free = {f"{line.user.name}.device.x": freedom_of(line) for line in loop.lines}
    found = [
        Motion(x, axis, ~each.tied[:, 0], {x: one}, {})
        for x, each in free.items()
        if not each.tied.all()
    ]
    if loop.body in linear.placed:
        together = {x: each.tied * one for x, each in free.items()}
        found.append(Motion(loop.body, axis, np.array([True]), {loop.body: one} | together, {}))
    for index, (line, (x, each)) in enumerate(zip(loop.lines, free.items(), strict=True)):
        if each.loose.any():
            e = loop.deflection(index)
            found.append(Motion(e, axis, each.loose[:, 0], {e: one, x: each.tied * one}, {}))
        loose = per_run(line.user.master.local_model.stiffness)[:, 0] == 0.0
        if loose.any():
            found += [
                Motion(spring, axis, loose, {spring: one}, {})
                for spring in linear.placed
                if spring.startswith(f"{line.user.name}.port.filters")
            ]
    return found


def _drifting(linear: "Linear", axis: int) -> list[Motion]:
    """Return the uniform motions: of all that hang together, and of users by themselves.

    A virtual coupling pulls back what moves on: it receives the other end late. So does a contact
    with damping behind a playout whose lag follows uneven packets, or, without waves, one that is
    told of the motion not equally late at every step: it is stretched in turns.
    """
    loop, found = linear.loop, []
    one = np.eye(loop.dof)[axis : axis + 1]
    for index, line in enumerate(loop.lines):
        _, alone, tied, braked = freedom_of(line)
        mask = alone & ~braked & ~(tied & line.waves)
        if mask.any():
            x, xd, e = (
                f"{line.user.name}.device.x",
                f"{line.user.name}.device.xd",
                loop.deflection(index),
            )
            b = line.user.impedance, line.user.server_impedance
            rates = {x: one, e: _passed(line, one, *b)}
            found.append(Motion(xd, axis, mask[:, 0], {xd: one}, rates))
    steady = all(abs(pace.shift_s) < ROUNDING_S for pair in loop.paces for pace in pair)
    steady &= all(line.waves or len(set(line.ages(loop.ticks))) == 1 for line in loop.lines)
    if loop.body in linear.placed and steady:
        found += _common_drift(linear, axis)
    return found


def _common_drift(linear: "Linear", axis: int) -> list[Motion]:
    """Return the uniform motion of the object with all users who touch it, where none is braked.

    The two ends of a wave link move as sqrt(b of the server / b of the master). A position
    feedback receives the avatar in steps: only with a packet at every tick is there no force.
    """
    loop, body, serve = linear.loop, linear.loop.body, linear.loop.serve
    one = np.eye(loop.dof)[axis : axis + 1]
    mask = ~(per_run(loop.scenario.server.object_damping) > 0.0)
    now = {body: one * ((serve.phase - serve.period) * loop.tick_s), f"{body}d": one}
    rates = {body: one}
    for index, line in enumerate(loop.lines):
        _, off, tied, braked = freedom_of(line)
        rates[loop.deflection(index)] = np.where(off, -one, 0.0)  # stays behind
        ratio = _passed(line, one, line.user.server_impedance, line.user.impedance)
        same = np.all(ratio == one, axis=1, keepdims=True)
        steady = (same & (line.answer.period == serve.period == 1)) | ~tied | (not line.waves)
        mask = mask & (off | ~braked) & (off | steady)
        received = serve.last(line.answer.last(0) - line.delay_down)  # sent at, of the answer
        late = tied * received if line.waves else line.ages(loop.ticks)[0]
        x = f"{line.user.name}.device.x"
        rates[x] = np.where(off, 0.0, ratio)
        now |= {x: rates[x] * (late * loop.tick_s), f"{x}d": rates[x]}
    return [Motion(f"{body}d", axis, mask[:, 0], now, rates)] if mask.any() else []


def _passed(line: Line, xd: Array, sent: Impedance, received: Impedance) -> Array:
    """Return the velocity of one end of a line while the other one moves with xd, both without a
    force: that of the wave at a port of another impedance; without waves it is the same.
    """
    if not line.waves:
        return xd
    ends: list[Any] = [
        b if isinstance(b, MatrixImpedance) else per_run(b) for b in (sent, received)
    ]
    return np.asarray(root(ends[0]) * xd / root(ends[1]))
