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

from collections.abc import Sequence

from pmwvc_core.numeric import Value
from pmwvc_core.params import ServerParams
from pmwvc_core.server.couplings.record import Coupling
from pmwvc_core.server.couplings.sampled import push_object, weights
from pmwvc_core.server.cube import Body
from pmwvc_core.server.user_ports import UserPort


class Unwrapped:
    """Solve each avatar with its contact."""

    def __init__(self, params: ServerParams) -> None:
        self._period = params.period_s
        self._old, self._new = weights(params.integrator, params.period_s)

    def step(self, ports: Sequence[UserPort], body: Body) -> Value:
        """Use every port's ``u_s``; return the energy dissipated [J]."""
        lost = push_object(ports, body)
        for port in ports:
            lost = lost + port.contact.slide(self._old * port.xd_s)
            free = port.wave.free_velocity(port.u_s)
            port.f_s = port.contact.unwrapped(free, body.xd, port.b, self._new)
            port.xd_s = free - port.f_s / port.b
            lost = lost + port.contact.slide(self._new * port.xd_s)
            lost = lost + self._period * port.contact.heat(port.xd_s - body.xd)
        return lost


RECORD = Coupling(
    name="unwrapped",
    words="Each avatar is solved with its contact against the object as sampled: passive at a "
    "wall, except with forward Euler.",
    linear="unwrapped",
    make=Unwrapped,
    balanced=True,
)
