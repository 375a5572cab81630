# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Encode and decode at both ends of the wave channel (App. B Fig. 1).

A wave pair carries the same power as the force and velocity of its port, F xd = (u^2 - v^2)/2, for
*any* impedance b > 0: ends with different b form a lossless transformer, not an error. ``u`` runs
to the server, ``v`` to the master, both in sqrt(W). Several axes share a scalar b, and runs of a
batch may have their own, ``(runs, 1)``; or b is a matrix that couples the axes
(:mod:`pmwvc_core.wave.impedance`).

Equations: docs/theory.md 1.5.
"""

from pmwvc_core.numeric import Value, root, squared
from pmwvc_core.wave.impedance import Impedance


def encode_master(xd_m: Value, v_m: Value, b: Impedance) -> Value:
    """Return the wave that leaves the master, u_m = sqrt(2b) xd_m - v_m [sqrt(W)].

    Parameters
    ----------
    xd_m
        Device velocity [m/s], float or ``(..., dof)``.
    v_m
        Returning wave [sqrt(W)].
    b
        Wave impedance [N s/m].
    """
    return root(2.0 * b) * xd_m - v_m


def decode_master(xd_m: Value, v_m: Value, b: Impedance) -> Value:
    """Return the force of the controller against the hand, F_m = b xd_m - sqrt(2b) v_m [N]."""
    return b * xd_m - root(2.0 * b) * v_m


def encode_server(u_s: Value, f_s: Value, b: Impedance) -> Value:
    """Return the wave that leaves the server, v_s = u_s - sqrt(2/b) F_s [sqrt(W)].

    Parameters
    ----------
    u_s
        Arriving wave [sqrt(W)], float or ``(..., dof)``.
    f_s
        Force of the avatar on what it touches [N].
    b
        Wave impedance of this port [N s/m].
    """
    return u_s - root(2.0 / b) * f_s


def decode_server(u_s: Value, f_s: Value, b: Impedance) -> Value:
    """Return the velocity of the avatar, xd_s = sqrt(2/b) u_s - F_s / b [m/s]."""
    return root(2.0 / b) * u_s - f_s / b


def power(u: Value, v: Value) -> Value:
    """Return the power that runs towards the server, (|u|^2 - |v|^2)/2 [W], one per run."""
    return 0.5 * (squared(u) - squared(v))
