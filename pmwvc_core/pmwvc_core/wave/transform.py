# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The wave transformation at both ends of the channel (App. B Fig. 1).

A wave pair carries the same power as the force and velocity of its port, F xd = (u^2 - v^2)/2, for
*any* impedance b > 0: ends with different b form a lossless transformer, not an error. ``u`` runs
to the server, ``v`` to the master, both in sqrt(W). Several axes share a scalar b, or b is a
matrix that couples them (:mod:`pmwvc_core.wave.impedance`).

Equations: those of :mod:`pmwvc_core.law.wave.wave`, for arrays.
"""

from pmwvc_core.numeric import Value, root
from pmwvc_core.wave.impedance import Impedance


class WavePort:
    """Both directions through a port of impedance ``b`` [N s/m]; signals are floats or ``(...,
    dof)``. Forces count as in the figure: F_m against the hand, F_s of the avatar on what it
    touches.
    """

    __slots__ = ("_root_2_over_b", "_root_2b", "b")

    def __init__(self, b: Impedance) -> None:
        self.b = b  # acts like a number, also where it is a matrix
        self._root_2b = root(2.0 * b)
        self._root_2_over_b = root(2.0 / b)

    def u(self, xd: Value, v: Value) -> Value:
        """Return the wave that leaves the master, u = sqrt(2b) xd - v [sqrt(W)]."""
        return self._root_2b * xd - v

    def force(self, xd: Value, v: Value) -> Value:
        """Return the force against the hand, F = b xd - sqrt(2b) v [N]."""
        return self.b * xd - self._root_2b * v

    def v(self, u: Value, f: Value) -> Value:
        """Return the wave that leaves the server, v = u - sqrt(2/b) F [sqrt(W)]."""
        return u - self._root_2_over_b * f

    def velocity(self, u: Value, f: Value) -> Value:
        """Return the velocity of the avatar, xd = sqrt(2/b) u - F/b [m/s]."""
        return self._root_2_over_b * u - f / self.b
