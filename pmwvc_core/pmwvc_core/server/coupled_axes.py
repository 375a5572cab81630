# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Contacts behind a wave port whose impedance B couples the axes.

The laws are those of :mod:`.contacts` and :mod:`.friction`; what changes is the loop, xd = free -
B^-1 f. A two-sided contact is the same along every axis, so along the principal axes of B it is
one axis after the other. A grip pushes along axis 0 only; there, with Y = B^-1 in blocks, the
linear law across, f_t = l_t + g xd_t, is eliminated::

    f_t = S (l_t + g free_t - g Y_t0 f_0),                     S = (1 + g Y_tt)^-1
    xd_0 = (free_0 - Y_0t S (l_t + g free_t)) - f_0/b',        1/b' = Y_00 - g Y_0t S Y_t0

which leaves the law along axis 0 behind a number b' > 0 (a Schur complement), solved as ever. What
asks with a number instead (a controller without waves) gets the laws as they are.

Equations: docs/theory.md 6.4, 6.5.
"""

from typing import NamedTuple

import numpy as np

from pmwvc_core.numeric import Array, Value, dot, where
from pmwvc_core.server.contacts import Answer, Bilateral
from pmwvc_core.server.friction import AnchoredGrip
from pmwvc_core.wave.impedance import Impedance, MatrixImpedance, times


class CoupledAnswer(Answer):
    """An answer whose slope is a symmetric matrix ``(..., dof, dof)``."""


class CoupledBilateral(Bilateral):
    """Spring and damper that push and pull, solved along the principal axes of the impedance."""

    def unwrapped(self, free: Value, xd_o: Value, impedance: Impedance, weight: Value) -> Value:
        """Solve f = K (e + weight xd) + B (xd - xd_o), xd = free - f/impedance."""
        if not isinstance(impedance, MatrixImpedance):
            return super().unwrapped(free, xd_o, impedance, weight)
        gain = self.damping + weight * self.stiffness
        loose = self.stiffness * self.deflection + gain * free - self.damping * xd_o
        ratio = 1.0 + gain / impedance.values
        force: Array = impedance.from_principal(impedance.to_principal(loose) / ratio)
        return force

    def answer(self, free: Value, impedance: Impedance, period: Value) -> Answer:
        """Solve f = K (e + h w/2) + B w with w = free - f/impedance."""
        if not isinstance(impedance, MatrixImpedance):
            return super().answer(free, impedance, period)
        gain = 0.5 * self.stiffness * period + self.damping
        ratio = 1.0 + gain / impedance.values
        pull = self.stiffness * impedance.to_principal(self.deflection)
        wanted = impedance.to_principal(free)
        slope = np.asarray(gain / ratio)[..., np.newaxis, :]
        return CoupledAnswer(
            impedance.from_principal((pull + gain * wanted) / ratio),
            impedance.from_principal((wanted - pull / impedance.values) / ratio),
            (impedance.axes * slope) @ impedance.axes.T,
        )


class Eliminated(NamedTuple):
    """The axes across once they are eliminated."""

    held: Array  # (..., dof - 1) [N] their force while f_0 is zero
    lean: Array  # (..., dof - 1) [-] by how much it grows with f_0
    stiff: Array  # (..., dof - 1, dof - 1) [N s/m] by how much it grows with free_t
    less: Array  # (..., 1) [m/s] what it takes from the velocity along axis 0
    impedance: Array  # (..., 1) [N s/m] b', what axis 0 moves against


class CoupledGrip(AnchoredGrip):
    """A grip along axis 0 whose avatar holds on sideways."""

    def unwrapped(self, free: Value, xd_o: Value, impedance: Impedance, weight: Value) -> Value:
        """Solve the axes across with axis 0; the anchor holds where contact was before."""
        if not isinstance(impedance, MatrixImpedance):
            return super().unwrapped(free, xd_o, impedance, weight)
        anchor = self.anchor
        gain = self.damping + weight * self.stiffness
        (free_0, free_t), (xd_0, xd_t) = _split(free), _split(xd_o)
        loose = anchor.stiffness * anchor.deflection - anchor.damping * xd_t
        rest = self._eliminate(loose, gain, free_t, impedance)
        f_0 = self.grip.unwrapped(free_0 - rest.less, xd_0, rest.impedance, weight)
        return self._join(f_0, rest.held + rest.lean * f_0)

    def answer(self, free: Value, impedance: Impedance, period: Value) -> Answer:
        """Solve the axes across with axis 0; the anchor holds where the step begins inside."""
        if not isinstance(impedance, MatrixImpedance):
            return super().answer(free, impedance, period)
        gain = 0.5 * self.stiffness * period + self.damping
        free_0, free_t = _split(free)
        loose = self.anchor.stiffness * self.anchor.deflection
        rest = self._eliminate(loose, gain, free_t, impedance)
        along = self.grip.answer(free_0 - rest.less, rest.impedance, period)
        force = self._join(along.force, rest.held + rest.lean * along.force)
        _, rate_t = _split(free - force / impedance)
        course = self._join(np.ones(1), rest.lean)
        slope = np.asarray(along.slope)[..., np.newaxis] * (
            course[..., :, np.newaxis] * course[..., np.newaxis, :]
        )
        slope[..., 1:, 1:] += rest.stiff
        return CoupledAnswer(force, self._join(along.rate, rate_t), slope)

    def _eliminate(
        self, loose: Value, gain: Value, free: Value, impedance: MatrixImpedance
    ) -> Eliminated:
        """Solve f_t = loose + gain xd_t for what it leaves to axis 0; f_t = 0 where not held."""
        yields = impedance.inverse().matrix
        lead = yields[0, 1:]
        gain = np.asarray(where(self.touching, gain, 0.0))
        loose = where(self.touching, loose, 0.0)
        loop = np.eye(len(lead)) + gain[..., np.newaxis] * yields[1:, 1:]
        ratio = np.asarray(np.linalg.inv(loop), dtype=np.float64)
        held = times(ratio, loose + gain * free)
        lean = -gain * times(ratio, lead)
        softness = yields[0, 0] + np.asarray(dot(lean, lead))
        return Eliminated(
            held,
            lean,
            gain[..., np.newaxis] * ratio,
            np.asarray(dot(held, lead)),
            1.0 / softness,
        )


def _split(value: Value) -> tuple[Array, Array]:
    """Return the components along axis 0 and across; the zero of a start is zero along all."""
    array = np.atleast_1d(value)
    if array.shape[-1] == 1:
        return array, array
    return array[..., :1], array[..., 1:]
