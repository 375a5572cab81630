# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Energies of a damped mass over ticks of which the motion is known: heat and account."""

import numpy as np

from pmwvc_core.account import Account
from pmwvc_core.numeric import Array, Value, dot, root, squared
from pmwvc_core.params import DeviceParams

NODES, WEIGHTS = np.polynomial.legendre.leggauss(4)  # on -1..1; as good as exact for small b t/m


def damper_heat(mass: float, damping: float, time_s: Value, xd: Array, force: Array) -> Array:
    """Return b times the integral of |xd|^2 over times, of each row or of all, that begin with
    ``xd`` [m/s] and have a constant force [N], ``(ticks, dof)`` [J].

    It is taken from the velocity itself, not from the balance of the other energies.
    """
    square = np.zeros(())
    for node, weight in zip(NODES, WEIGHTS, strict=True):
        part_s = 0.5 * (1.0 + node) * time_s
        z = damping * part_s / mass
        grows = -np.expm1(-z) / damping if damping > 0.0 else part_s / mass
        square = square + 0.5 * weight * squared(np.exp(-z) * xd + grows * force)
    return np.asarray(damping * time_s * square)


def device_account(
    params: DeviceParams,
    tick_s: float,
    before: tuple[Array, Array],
    after: tuple[Array, Array],
    f_h: Array | None,
    f_m: Array,
) -> Account:
    """Return the energy of a device over ticks of which its true motion is known [J].

    ::

        taken       f_h . (x+ - x), a force held over a tick works on what it moves
        given       f_m . (x+ - x), to the force of the controller
        stored      m (|xd+|^2 - |xd|^2)/2
        dissipated  b_hd times the integral of |xd|^2, and friction |x+ - x|; at a stop the rest

    ``before`` and ``after`` are position [m] and velocity [m/s] at the start and at the end of
    each tick, ``f_h`` and ``f_m`` the forces of hand and controller [N], all ``(ticks, dof)``. A
    hand whose force is not known (None) is taken to have given what the device shows.
    """
    (x, xd), (x_after, xd_after) = before, after
    moved = x_after - x
    push = -f_m if f_h is None else f_h - f_m
    stored = 0.5 * params.mass * (squared(xd_after) - squared(xd))
    if f_h is not None and params.friction == 0.0:
        heat = damper_heat(params.mass, params.damping, tick_s, xd, push)
    else:  # within a tick the velocity is as good as a straight line
        square = squared(xd) + dot(xd, xd_after) + squared(xd_after)
        heat = np.asarray(params.damping * tick_s / 3.0 * square)
    heat = heat + params.friction * root(squared(moved))
    stopped = (np.abs(x_after) >= params.workspace_m).any(axis=-1, keepdims=True)
    heat = np.where(stopped, dot(push, moved) - stored, heat)
    given = dot(f_m, moved)
    taken = given + stored + heat if f_h is None else dot(f_h, moved)
    return Account(taken, given, stored, heat)
