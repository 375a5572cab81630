# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The brake at an avatar: it holds the contact while no waves of its user come.

A silent port is a damper b, in front of which a grip of 1.5 N opens within milliseconds. A damper
(N - 1) b beside the port holds it. The coupling then solves a port of impedance N b, whatever its
law, and the waves of the user are those in front of the damper::

    u' = u/sqrt(N),   v = (u' + v')/sqrt(N) - u
    (|u|^2 - |v|^2)/2 = (|u'|^2 - |v'|^2)/2 + (N - 1)/(2 N) |u' + v'|^2

The last term is heat. So with any N >= 1, which may change at every step, the port returns no more
than it would without: N is chosen for a friction of at most F_L
(:mod:`pmwvc_core.wave.brake_force`) against the contact's force R that the wave leaves over::

    R = f_s - sqrt(2b) u,   N = |R|/(|R| - F_L), at most ``FIRMEST``; 1 where R . f_s <= 0

A wave that pushes into the contact meets no brake.

Equations: docs/theory.md 17.13.
"""

from typing import Any

import numpy as np

from pmwvc_core.account import Entry, Role
from pmwvc_core.numeric import Flag, Value, dot, maximum, root, squared, where
from pmwvc_core.state import Stateful
from pmwvc_core.wave.brake_force import BrakeForce
from pmwvc_core.wave.impedance import MatrixImpedance
from pmwvc_core.wave.transform import WavePort

FIRMEST = 1000.0  # 1.6 N move the avatar behind 25 N s/m with less than 0.1 mm/s
RETURN_S = 0.1
BRAKES = "avatar_brakes"
ENTRIES = (
    Entry(
        BRAKES,
        "dissipated by the brakes of the avatars",
        Role.SHOWN,
        part="brakes of the avatars while no waves came",
    ),
)


class AvatarBrake(Stateful):
    """See the module.

    Parameters
    ----------
    period_s
        Period of the server [s].

    Attributes
    ----------
    waits
        Whether no waves of the user come; set before every step.
    heat_j
        Heat so far [J], one per run.
    """

    BLOCKS = "_largest"
    MEMORY = "waits heat_j"

    def __init__(self, *, period_s: float) -> None:
        self._largest = BrakeForce(step_s=period_s, return_s=RETURN_S)
        self._half_s = 0.5 * period_s
        self.waits: Flag = False
        self.heat_j: Value = 0.0

    def last(self, period_s: float) -> None:
        """Take steps of another length over [s]."""
        self._largest.last(period_s)
        self._half_s = 0.5 * period_s

    def reset(self) -> None:
        """Let go at once; what became heat stays counted."""
        self._largest.reset()
        self.waits = False

    def ratio(self, port: WavePort, u: Value, f_s: Value) -> Value | None:
        """Return N for a step; None where nothing brakes.

        Parameters
        ----------
        port, u
            The user's own port, and the wave received [sqrt(W)].
        f_s
            Contact force of the last step [N].
        """
        self._largest.step(self.waits, f_s)
        if self._largest.idle:
            return None
        left: Value = f_s - port.b * port.free_velocity(u)
        size = root(squared(left))
        over = maximum(size - self._largest.limit, size * (1.0 / FIRMEST))
        yields = (dot(left, f_s) > 0.0) & (self._largest.limit > 0.0)
        ratio = where(yields, size / where(size > 0.0, over, 1.0), 1.0)
        if isinstance(port.b, MatrixImpedance):  # one number: it acts on the matrix
            return float(np.max(ratio))
        return ratio

    def wave(self, u: Value, inner: tuple[Value, Value], ratio: Value) -> Value:
        """Return the wave in front of the damper [sqrt(W)], and count its heat.

        Parameters
        ----------
        u
            The wave received [sqrt(W)].
        inner
            u' and v' [sqrt(W)].
        ratio
            N of the step.
        """
        both: Any = inner[0] + inner[1]
        self.heat_j = self.heat_j + (1.0 - 1.0 / ratio) * self._half_s * squared(both)
        returned: Value = both / root(ratio) - u
        return returned
