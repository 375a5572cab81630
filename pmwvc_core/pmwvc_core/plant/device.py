# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The simulated force-feedback device: m x'' + b_hd x' = f_h - F_m, plus what a real one adds.

Mass and damper are advanced exactly over a tick with both forces held. Coulomb friction acts
against the motion at the start of a tick; along one axis it is exact. The stops of the workspace
are perfectly inelastic. The encoder rounds to its nearest step; the velocity signal is the true
one, or the difference of the last two readings over a tick.
"""

import math
from typing import NamedTuple

import numpy as np

from pmwvc_core.account import Account
from pmwvc_core.errors import ParameterError
from pmwvc_core.law.motion import StepMap, advanced, motion, time_to_rest
from pmwvc_core.law.vectors import Vector, columns, dot, each, length, minus, scaled, within, zero
from pmwvc_core.numeric import Array, Value, root, squared
from pmwvc_core.numeric import dot as inner
from pmwvc_core.params import DeviceParams


class Device(NamedTuple):
    """True motion, what is read of it, and work: force held in a tick times true distance."""

    x: Vector  # [m]
    xd: Vector  # [m/s]
    read_x: Vector  # [m]
    read_xd: Vector  # [m/s]
    against_j: float  # of the controller's force against the hand
    by_hand_j: float  # of the hand's force on the device


class SimulatedParams(NamedTuple):
    """Parameters of a simulated device over a tick."""

    mass: float
    damping: float
    friction: float
    encoder_step_m: float  # 0: exact
    reach_m: float
    differences: bool  # velocity by differences of readings
    tick_s: float
    motion: StepMap


def simulated_params(params: DeviceParams, tick_s: float) -> SimulatedParams:
    """Return the parameters of a device for a period of the force loop."""
    coefficients = motion(params.mass, params.damping, tick_s)
    return SimulatedParams(
        params.mass, params.damping, params.friction, params.encoder_step_m, params.workspace_m,
        params.differences, tick_s, coefficients,
    )  # fmt: skip


def resting_device(x: Vector, p: SimulatedParams) -> Device:
    """Return a device at rest at a position [m]; ParameterError outside its workspace."""
    if max(x) > p.reach_m or min(x) < -p.reach_m:
        raise ParameterError(
            f"device placed at {list(x)} m: outside its workspace of +-{p.reach_m} m; make "
            "device.workspace_m larger"
        )
    return Device(x, zero(x), _measured(x, p), zero(x), 0.0, 0.0)


def device_step(
    s: Device, f_h: Vector, f_m: Vector, p: SimulatedParams
) -> tuple[Device, Vector, Vector]:
    """Advance one tick, both forces held [N]; return also what is read at its end."""
    force = minus(f_h, f_m)
    if p.friction > 0.0:
        x, xd = _rubbed(s.x, s.xd, force, p)
    else:
        x, xd = advanced(s.x, s.xd, force, p.motion)
    if not within(x, p.reach_m):
        x, xd = columns(each(_stopped, (x, xd), p.reach_m))
    moved = minus(x, s.x)
    read_x, read_xd = _measured(x, p), xd
    if p.differences:
        read_xd = scaled(minus(read_x, s.read_x), 1.0 / p.tick_s)
    against_j, by_hand_j = s.against_j + dot(f_m, moved), s.by_hand_j + dot(f_h, moved)
    return Device(x, xd, read_x, read_xd, against_j, by_hand_j), read_x, read_xd


def _stopped(x: float, xd: float, reach_m: float) -> tuple[float, float]:
    if x >= reach_m:
        return reach_m, 0.0
    return (-reach_m, 0.0) if x <= -reach_m else (x, xd)


def _measured(x: Vector, p: SimulatedParams) -> Vector:
    return each(_rounded, (x,), p.encoder_step_m) if p.encoder_step_m > 0.0 else x


def _rounded(x: float, step_m: float) -> float:
    return math.floor(x / step_m + 0.5) * step_m


def _rubbed(x: Vector, xd: Vector, force: Vector, p: SimulatedParams) -> tuple[Vector, Vector]:
    """Advance one tick with Coulomb friction against the direction of motion, kept until the
    motion along it comes to rest (once at most); from there the other forces hold still or win for
    good.
    """
    speed, course, wins = length(xd), _direction(xd), length(force) - p.friction
    push = scaled(_direction(force), max(wins, 0.0))  # what wins from rest
    net = minus(force, scaled(course, p.friction)) if speed > 0.0 else push
    x_end, xd_end = advanced(x, xd, net, p.motion)
    if not dot(course, xd_end) < 0.0:
        return x_end, xd_end
    time_s = time_to_rest(p.mass, p.damping, speed, dot(course, net))
    time_s = min(max(time_s, 0.0), p.tick_s)
    x_rest, across = advanced(x, xd, net, motion(p.mass, p.damping, time_s))
    across = minus(across, scaled(course, dot(course, across))) if wins > 0.0 else zero(xd)
    return advanced(x_rest, across, push, motion(p.mass, p.damping, p.tick_s - time_s))


def _direction(a: Vector) -> Vector:
    """Return the unit vector; nothing where there is none."""
    size = length(a)
    return scaled(a, 1.0 / size) if size > 0.0 else a


NODES, WEIGHTS = np.polynomial.legendre.leggauss(4)  # on -1..1; as good as exact for small b t/m


def damper_heat(mass: float, damping: float, time_s: Value, xd: Array, force: Array) -> Array:
    """Return b times the integral of |xd|^2 over times that begin with ``xd`` [m/s] and have a
    constant force [N], ``(ticks, dof)`` [J]: from the velocity, not from the balance of the other
    energies.
    """
    square = np.zeros(())
    for node, weight in zip(NODES, WEIGHTS, strict=True):
        part_s = 0.5 * (1.0 + node) * time_s
        z = damping * part_s / mass
        grows = -np.expm1(-z) / damping if damping > 0.0 else part_s / mass
        square = square + 0.5 * weight * squared(np.exp(-z) * xd + grows * force)
    return np.asarray(damping * time_s * square)


def device_account(
    params: DeviceParams, tick_s: float, before: tuple[Array, Array], after: tuple[Array, Array],
    f_h: Array | None, f_m: Array,
) -> Account:  # fmt: skip
    """Return the energy of a device over ticks of which its true motion is known [J].

    ::

        taken       f_h . (x+ - x), a force held over a tick works on what it moves
        given       f_m . (x+ - x), to the force of the controller
        stored      m (|xd+|^2 - |xd|^2)/2
        dissipated  b_hd times the integral of |xd|^2, and friction |x+ - x|; at a stop the rest

    ``before`` and ``after`` are position [m] and velocity [m/s] of each tick, forces [N], all
    ``(ticks, dof)``. A hand of unknown force (None) has given what the device shows.
    """
    (x, xd), (x_after, xd_after) = before, after
    moved = x_after - x
    push = -f_m if f_h is None else f_h - f_m
    stored = 0.5 * params.mass * (squared(xd_after) - squared(xd))
    if f_h is not None and params.friction == 0.0:
        heat = damper_heat(params.mass, params.damping, tick_s, xd, push)
    else:  # within a tick the velocity is as good as a straight line
        square = squared(xd) + inner(xd, xd_after) + squared(xd_after)
        heat = np.asarray(params.damping * tick_s / 3.0 * square)
    heat = heat + params.friction * root(squared(moved))
    stopped = (np.abs(x_after) >= params.workspace_m).any(axis=-1, keepdims=True)
    heat = np.where(stopped, inner(push, moved) - stored, heat)
    given = inner(f_m, moved)
    taken = given + stored + heat if f_h is None else inner(f_h, moved)
    return Account(taken, given, stored, heat)
