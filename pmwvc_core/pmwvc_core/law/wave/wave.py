# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The wave transformation at both ends of the channel (App. B Fig. 1).

::

    u  = sqrt(2b) xd - v          F  = b xd - sqrt(2b) v          at the master
    v  = u - sqrt(2/b) F          xd = sqrt(2/b) u - F/b          at the server

F xd = (u^2 - v^2)/2 for *any* b > 0. F_m pushes against the hand, F_s is of the avatar on what it
touches. All axes have one b, or a symmetric positive matrix couples them.
Equations: docs/theory.md 1.1, 1.2, 1.3, 1.4, 1.5, 17.14.
"""

import math
from typing import Any, NamedTuple

from pmwvc_core.law.channel.constants import SETTLE_S, SLOWLY_S
from pmwvc_core.law.family import Family
from pmwvc_core.law.vectors import Vector, dot, each, inverse, minus, scaled, squared, times


class Impedance(NamedTuple):
    """One wave impedance b [N s/m] for all axes, 1/b, its roots, and its only eigenvalue."""

    b: float
    inverse: float
    root_2b: float
    root_2_over_b: float
    values: Vector


def impedance(b: float) -> Impedance:
    """Return the impedance b [N s/m] with its roots."""
    return Impedance(b, 1.0 / b, math.sqrt(2.0 * b), math.sqrt(2.0 / b), (b,))


Rows = tuple[Vector, ...]


class ImpedanceMatrix(NamedTuple):
    """A symmetric positive wave impedance, by rows."""

    b: Rows  # [N s/m]
    inverse: Rows
    root_2b: Rows
    root_2_over_b: Rows
    numbers: tuple[int, ...]  # of the axes, 0, 1 ...
    values: Vector  # eigenvalues
    to_axes: Rows  # its own
    from_axes: Rows


def applied(matrix: Rows, a: Vector) -> Vector:
    """Return a matrix times a vector."""
    return each(dot, (matrix,), a)


def outer(a: Vector, b: Vector) -> Rows:
    """Return a b^T."""
    return each(_multiple, (a,), b)


def _multiple(factor: float, row: Vector) -> Vector:
    return scaled(row, factor)


times_part = Family("times_part")  # (impedance, one of its numbers or matrices, a) -> that times a
firmer = Family("firmer")  # (impedance, n) -> n times it; of axes that a matrix couples one n
along = Family("along")  # (impedance, gains, a) -> a with a gain for each eigenvalue


@times_part.member(Impedance)
def _times_number(p: Impedance, part: float, a: Vector) -> Vector:
    return scaled(a, part)


@times_part.member(ImpedanceMatrix)
def _times_matrix(p: ImpedanceMatrix, part: Rows, a: Vector) -> Vector:
    return applied(part, a)


def damper(p: Any, xd: Vector) -> Vector:
    """Return b xd [N]."""
    return times_part(p, p.b, xd)


def rooted(p: Any, a: Vector) -> Vector:
    """Return sqrt(2b) a."""
    return times_part(p, p.root_2b, a)


def free_velocity(p: Any, u: Vector) -> Vector:
    """Return sqrt(2/b) u [m/s], the velocity of one that touches nothing."""
    return times_part(p, p.root_2_over_b, u)


def loaded(p: Any, free: Vector, f: Vector) -> Vector:
    """Return free - f/b [m/s], the velocity of one that bears a force."""
    return minus(free, times_part(p, p.inverse, f))


@along.member(Impedance)
def _along(p: Impedance, gains: Vector, a: Vector) -> Vector:
    return scaled(a, gains[0])


@along.member(ImpedanceMatrix)
def _matrix_along(p: ImpedanceMatrix, gains: Vector, a: Vector) -> Vector:
    return applied(p.from_axes, times(applied(p.to_axes, a), gains))


@firmer.member(Impedance)
def _firmer(p: Impedance, n: Vector) -> Impedance:
    return impedance(n[0] * p.b)


@firmer.member(ImpedanceMatrix)
def _firmer_matrix(p: ImpedanceMatrix, n: Vector) -> ImpedanceMatrix:
    root = each(math.sqrt, (n,))
    return p._replace(  # eigenvalues are for a master, which has no brake
        b=each(scaled, (p.b, n)), inverse=each(scaled, (p.inverse, inverse(n))),
        root_2b=each(scaled, (p.root_2b, root)),
        root_2_over_b=each(scaled, (p.root_2_over_b, inverse(root))),
    )  # fmt: skip


def wave_u(b: Any, xd: Vector, v: Vector) -> Vector:
    """Return the wave that leaves the master, sqrt(2b) xd - v [sqrt(W)]."""
    return minus(rooted(b, xd), v)


def wave_force(b: Any, xd: Vector, v: Vector) -> Vector:
    """Return the force against the hand, b xd - sqrt(2b) v [N]."""
    return minus(damper(b, xd), rooted(b, v))


def wave_v(b: Any, u: Vector, f: Vector) -> Vector:
    """Return the wave that leaves the server, u - sqrt(2/b) F [sqrt(W)]."""
    return minus(u, free_velocity(b, f))


def wave_velocity(b: Any, u: Vector, f: Vector) -> Vector:
    """Return the velocity of the avatar, sqrt(2/b) u - F/b [m/s]."""
    return loaded(b, free_velocity(b, u), f)


def wave_j(wave: Vector, time_s: float) -> float:
    """Return the energy that a wave carries in a time, |w|^2 T/2 [J]."""
    return 0.5 * time_s * squared(wave)


def affordable(wave: Vector, change: Vector, power: float) -> tuple[Vector, float]:
    """Return the longest part s w, 0 <= s <= 1, of a change w of a wave v [sqrt(W)] for which its
    cost |v + s w|^2 - |v|^2 <= power, twice what may be spent [W]; and that cost.
    """
    along, size = dot(wave, change), squared(change)
    cost = 2.0 * along + size
    if cost <= power:
        return change, cost
    ratio = 0.0
    if size > 0.0:
        most = math.sqrt(along * along + max(size * power, 0.0)) - along
        ratio = max(min(most / size, 1.0), 0.0)
    return scaled(change, ratio), ratio * (2.0 * along + ratio * size)


def repayment(undelivered: Vector, wave: Vector, free_j: float) -> Vector:
    """Return the wave that delivers what is undelivered, U [sqrt(W) s], as fast as E allows, the
    energy that may be spent [J]. A wave w along U beside v costs v + w/2 for each part of it: so
    w = 2 (E/|U| - v), within the time constants ``SLOWLY_S`` and ``SETTLE_S``.
    """
    size = math.sqrt(squared(undelivered))
    if size == 0.0:
        return undelivered
    along = scaled(undelivered, 1.0 / size)
    wanted = min(2.0 * (free_j / size - dot(wave, along)), size * (1.0 / SETTLE_S))
    return scaled(along, max(wanted, size * (1.0 / SLOWLY_S)))
