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
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmwvc_analysis.models.motions import freedom
from pmwvc_analysis.models.motions.freedom import per_run
from pmwvc_core.controllers.library import has_waves, record_of
from pmwvc_core.numeric import Array

if TYPE_CHECKING:
    from pmwvc_analysis.models.linearize import Linear

ROUNDING_S = 1e-12  # of a lag that does not change
Signals = dict[str, Array]  # of signals by name, a row or one per run, along each axis


class Motion(NamedTuple):
    """A motion by what moves in it; see :attr:`.linearize.Linear.placed`."""

    pivot: str
    axis: int
    mask: NDArray[np.bool_]  # (runs or 1,): which runs have it
    position: Signals  # where it begins, else zero; there of velocities their value
    velocity: Signals  # how fast positions change, else they stay


class Family(NamedTuple):
    """A motion t with A t = t, once the families before it are taken out."""

    vector: Array  # (runs, n), 1 at the pivot where the mask is set
    pivot: int
    mask: NDArray[np.bool_]  # (runs or 1,)


def motions(linear: "Linear") -> list[Motion]:
    """Return the motions of a loop, translations first."""
    axes = range(linear.loop.dof)
    still = [motion for axis in axes for motion in _free_positions(linear, axis)]
    return still + [motion for axis in axes for motion in _drifting(linear, axis)]


def families(linear: "Linear") -> list[Family]:
    """Return the motions of a loop as vectors of its states.

    Devices, object, deflections and springs are as given above; all other states follow from z(n)
    = z0 + n z1, z(n+1) = A z(n).
    """
    loop, n, found = linear.loop, len(linear.columns), motions(linear)
    matrices = linear.matrices
    now, change = np.zeros((2, len(matrices), n, len(found)))
    given = np.zeros(n, dtype=np.bool_)
    for (name, axis), column in linear.columns.items():
        if name not in linear.placed:
            continue
        given[column] = True
        for index, motion in enumerate(found):
            if name in motion.position:
                now[:, column, index] = motion.position[name][:, axis]
            if name in motion.velocity:
                period_s = loop.ticks * loop.tick_s
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
    runs, states = matrices.shape[0], matrices.shape[-1]
    gone: list[int] = []
    vectors = [np.broadcast_to(f.vector, (runs, states)).copy() for f in found]
    for index, family in enumerate(found):
        j = family.pivot
        mask = np.broadcast_to(family.mask, runs)[:, np.newaxis]
        t = np.where(mask, vectors[index], 0.0)
        matrices -= t[:, :, np.newaxis] * matrices[:, j : j + 1, :]
        keep = np.where(mask, 0.0, 1.0)
        matrices[:, j, :] *= keep
        matrices[:, :, j] *= keep
        for other in vectors[index + 1 :]:
            other -= t * other[:, j : j + 1]
        if mask.all():
            gone.append(j)
    left = np.setdiff1d(np.arange(states), gone)
    return matrices[:, left[:, np.newaxis], left]


def radius(matrices: Array) -> Array:
    """Return the spectral radius of each matrix."""
    if matrices.shape[-1] == 0:
        return np.zeros(len(matrices))
    found: Array = np.abs(np.linalg.eigvals(matrices)).max(axis=-1)
    return found


def count(found: Sequence[Family | Motion]) -> int:
    """Return how many motions the first run has."""
    return sum(bool(each.mask[0]) for each in found)


def _free_positions(linear: "Linear", axis: int) -> list[Motion]:
    loop, body = linear.loop, linear.loop.places.body
    if not has_waves(loop.scenario.controller):
        return _translations_without_waves(linear, axis)
    one, always = np.eye(loop.dof)[axis : axis + 1], np.array([True])
    tied = [freedom.tied(line) for line in loop.lines]
    devices = [f"{line.name}.device.x" for line in loop.lines]
    found = [
        Motion(device, axis, ~bound[:, 0], {device: one}, {})
        for device, bound in zip(devices, tied, strict=True)
        if not bound.all()
    ]
    together = {device: bound * one for device, bound in zip(devices, tied, strict=True)}
    if body in linear.placed:
        found.append(Motion(body, axis, always, {body: one} | together, {}))
    for index, line in enumerate(loop.lines):
        loose = freedom.stiffness(line)[:, 0] == 0.0
        if loose.any():
            e = loop.places.deflection(index)
            moved = {e: one, devices[index]: together[devices[index]]}
            found.append(Motion(e, axis, loose, moved, {}))
        loose = per_run(line.user.master.local_model.stiffness)[:, 0] == 0.0
        if loose.any():  # the spring of a local model that exerts nothing
            found += [
                Motion(spring, axis, loose, {spring: one}, {})
                for spring in linear.placed
                if spring.startswith(f"{line.name}.port.filters")
            ]
    return found


def _translations_without_waves(linear: "Linear", axis: int) -> list[Motion]:
    """Return the common translation, and those of users whose position acts on nothing."""
    loop, body, found = linear.loop, linear.loop.places.body, []
    one = np.eye(loop.dof)[axis : axis + 1]
    for index, line in enumerate(loop.lines):
        loose, device = freedom.stiffness(line)[:, 0] == 0.0, f"{line.name}.device.x"
        if loose.any():
            moved = {device: one, loop.places.deflection(index): one}
            found.append(Motion(device, axis, loose, moved, {}))
    if body in linear.placed:
        all_of_them = {f"{line.name}.device.x": one for line in loop.lines} | {body: one}
        found.append(Motion(body, axis, np.array([True]), all_of_them, {}))
    return found


def _drifting(linear: "Linear", axis: int) -> list[Motion]:
    """Return the uniform motions: of all that hang together, and of users by themselves.

    A virtual coupling pulls back what moves on: it receives the other end late. So does a contact
    with damping behind a playout whose lag follows uneven packets.
    """
    loop, body = linear.loop, linear.loop.places.body
    if not record_of(loop.scenario.controller).drifts:
        return []
    one, found = np.eye(loop.dof)[axis : axis + 1], []
    for line in loop.lines:
        mask = freedom.alone(line) & ~freedom.braked(line) & ~freedom.tied(line)
        if mask.any():
            x, xd = f"{line.name}.device.x", f"{line.name}.device.xd"
            e = loop.places.deflection(loop.lines.index(line))
            avatar = freedom.moves_avatar(line, one)
            found.append(Motion(xd, axis, mask[:, 0], {xd: one}, {x: one, e: avatar}))
    steady = all(abs(pace.shift_s) < ROUNDING_S for pair in loop.paces for pace in pair)
    if body in linear.placed and steady and all(map(freedom.steady_age, loop.lines)):
        found += _common_drift(linear, axis)
    return found


def _common_drift(linear: "Linear", axis: int) -> list[Motion]:
    """Return the uniform motion of the object with all users who touch it, where none is braked.

    The two ends of a wave link move as sqrt(b of the server / b of the master). A position
    feedback receives the avatar in steps: only with a packet at every tick is there no force.
    """
    loop, body = linear.loop, linear.loop.places.body
    waves, serve = has_waves(loop.scenario.controller), loop.serve
    one = np.eye(loop.dof)[axis : axis + 1]
    mask = ~(per_run(loop.scenario.server.object_damping) > 0.0)
    now = {body: one * ((serve.phase - serve.period) * loop.tick_s), f"{body}d": one}
    rates = {body: one}
    for index, line in enumerate(loop.lines):
        off, tied = freedom.alone(line), freedom.tied(line)
        rates[loop.places.deflection(index)] = np.where(off, -one, 0.0)  # stays behind
        ratio = freedom.moves_device(line, one)
        rate = np.where(off, 0.0, ratio)
        steady = freedom.steady_answers(line) & np.all(ratio == one, axis=1, keepdims=True)
        mask = mask & (off | ~freedom.braked(line)) & (off | ~tied | steady)
        late = tied * freedom.received_at(line, 0) if waves else line.up.ages()[0]
        x = f"{line.name}.device.x"
        now |= {x: rate * (late * loop.tick_s), f"{x}d": rate}
        rates[x] = rate
    if not mask.any():
        return []
    return [Motion(f"{body}d", axis, mask[:, 0], now, rates)]
