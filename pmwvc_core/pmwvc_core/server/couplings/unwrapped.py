# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Unwrapped: the loop is solved per user, against the object as sampled (App. C, Eq. 4).

::

    xd_s = [sqrt(2 b) u_s - K (x' - x_o) + B xd_o] / (b + B + g K),     x_s = x' + g xd_s

with x' the position without the new velocity and g what that weighs in the position: h (backward
Euler, x' = x_s), h/2 (trapezoid, x' = x_s + h xd_s/2), 0 (forward Euler, x' = x_s + h xd_s, as
published). Before that the object has come here exactly, under the last f_s held. What it does
next is not foreseen. At a wall the port is passive for g = h and h/2, and for g = 0 while B >= K
h/2.

Equations: docs/theory.md 4.8.
"""

from pmwvc_core.numeric import Value
from pmwvc_core.server.couplings.record import Coupling
from pmwvc_core.server.couplings.sampled import Sampled
from pmwvc_core.server.cube import Body
from pmwvc_core.server.user_ports import UserPort


class Unwrapped(Sampled):
    """Solve each avatar with its contact."""

    def _move(self, port: UserPort, body: Body, lost: Value) -> Value:
        lost = lost + port.contact.slide(self._old * port.xd_s)
        free = port.wave.free_velocity(port.u_s)
        port.f_s = port.contact.unwrapped(free, body.xd, port.b, self._new)
        port.xd_s = free - port.f_s / port.b
        lost = lost + port.contact.slide(self._new * port.xd_s)
        return lost + self._period * port.contact.heat(port.xd_s - body.xd)


RECORD = Coupling(
    name="unwrapped",
    words="Each avatar is solved with its contact against the object as sampled: passive at a "
    "wall, except with forward Euler.",
    linear="unwrapped",
    make=Unwrapped,
    balanced=True,
)
