# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The wave transformation at both ends of the channel (App. B Fig. 1).

::

    u  = sqrt(2b) xd - v          F  = b xd - sqrt(2b) v          at the master
    v  = u - sqrt(2/b) F          xd = sqrt(2/b) u - F/b          at the server

A wave pair carries the power of its port, F xd = (u^2 - v^2)/2, for *any* impedance b > 0: ends
with different b form a lossless transformer, not an error. F_m pushes against the hand, F_s is of
the avatar on what it touches. All axes have one b, or a symmetric positive matrix couples them.

Equations: docs/theory.md 1.1, 1.2, 1.3, 1.4, 1.5.
"""

import math
from typing import NamedTuple

from pmwvc_core.law.family import Family
from pmwvc_core.law.vectors import Vector, dot, each, minus, scaled


class Impedance(NamedTuple):
    """One wave impedance b [N s/m] for all axes, and its roots."""

    b: float
    root_2b: float
    root_2_over_b: float


def impedance(b: float) -> Impedance:
    """Return the impedance b [N s/m] with its roots."""
    return Impedance(b, math.sqrt(2.0 * b), math.sqrt(2.0 / b))


Rows = tuple[Vector, ...]


class MatrixImpedance(NamedTuple):
    """A symmetric positive wave impedance B [N s/m], by rows: itself, its inverse, its roots; and
    the numbers of the axes, 0, 1 ...
    """

    b: Rows
    inverse: Rows
    root_2b: Rows
    root_2_over_b: Rows
    numbers: tuple[int, ...]


def applied(matrix: Rows, a: Vector) -> Vector:
    """Return a matrix times a vector."""
    return each(dot, (matrix,), a)


wave_u = Family("wave_u")  # (impedance, xd, v) -> u [sqrt(W)] that leaves the master
wave_force = Family("wave_force")  # (impedance, xd, v) -> F [N] against the hand
wave_v = Family("wave_v")  # (impedance, u, f) -> v [sqrt(W)] that leaves the server
wave_velocity = Family("wave_velocity")  # (impedance, u, f) -> xd [m/s] of the avatar
free_velocity = Family("free_velocity")  # (impedance, u) -> xd [m/s] of one that touches nothing
damper = Family("damper")  # (impedance, xd) -> b xd [N]


@wave_u.member(Impedance)
def _u(p: Impedance, xd: Vector, v: Vector) -> Vector:
    return minus(scaled(xd, p.root_2b), v)


@wave_force.member(Impedance)
def _force(p: Impedance, xd: Vector, v: Vector) -> Vector:
    return minus(scaled(xd, p.b), scaled(v, p.root_2b))


@wave_v.member(Impedance)
def _v(p: Impedance, u: Vector, f: Vector) -> Vector:
    return minus(u, scaled(f, p.root_2_over_b))


@wave_velocity.member(Impedance)
def _velocity(p: Impedance, u: Vector, f: Vector) -> Vector:
    return each(_axis_velocity, (u, f), p)


def _axis_velocity(u: float, f: float, p: Impedance) -> float:
    return p.root_2_over_b * u - f / p.b


@free_velocity.member(Impedance)
def _free(p: Impedance, u: Vector) -> Vector:
    return scaled(u, p.root_2_over_b)


@damper.member(Impedance)
def _damper(p: Impedance, xd: Vector) -> Vector:
    return scaled(xd, p.b)


@wave_u.member(MatrixImpedance)
def _matrix_u(p: MatrixImpedance, xd: Vector, v: Vector) -> Vector:
    return minus(applied(p.root_2b, xd), v)


@wave_force.member(MatrixImpedance)
def _matrix_force(p: MatrixImpedance, xd: Vector, v: Vector) -> Vector:
    return minus(applied(p.b, xd), applied(p.root_2b, v))


@wave_v.member(MatrixImpedance)
def _matrix_v(p: MatrixImpedance, u: Vector, f: Vector) -> Vector:
    return minus(u, applied(p.root_2_over_b, f))


@wave_velocity.member(MatrixImpedance)
def _matrix_velocity(p: MatrixImpedance, u: Vector, f: Vector) -> Vector:
    return minus(applied(p.root_2_over_b, u), applied(p.inverse, f))


@free_velocity.member(MatrixImpedance)
def _matrix_free(p: MatrixImpedance, u: Vector) -> Vector:
    return applied(p.root_2_over_b, u)


@damper.member(MatrixImpedance)
def _matrix_damper(p: MatrixImpedance, xd: Vector) -> Vector:
    return applied(p.b, xd)
