# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One-step delay: the wave is decoded with the force of the step before (App. B, Eq. 4).

::

    xd_s(n) = sqrt(2/b) u_s(n) - f_s(n-1)/b
    x_s(n)  = x_s(n-1) + h xd_s(n-1)                     forward Euler
            = x_s(n-1) + h xd_s(n)                       backward Euler
            = x_s(n-1) + h [xd_s(n-1) + xd_s(n)]/2       trapezoid
    f_s(n)  = K [x_s(n) - x_o(n)] + B [xd_s(n) - xd_o(n)]

where the object has come from n-1 to n exactly, under f_s(n-1) held. f_s and xd_s start at zero.

Passive at the wave port of a wall if and only if K h + 2 B <= b (backward Euler): with F = (K h
z/(z-1) + B) xd_s the reflection is (1 + F/(b z) - 2 F/b)/(1 + F/(b z)), whose length at z = -1 is
1 just at that bound. With the trapezoid it is active for every K > 0.

Equations: docs/theory.md 4.6.
"""

from pmwvc_core.numeric import Value
from pmwvc_core.server.couplings.record import Coupling
from pmwvc_core.server.couplings.sampled import Sampled, least_impedance
from pmwvc_core.server.cube import Body
from pmwvc_core.server.user_ports import UserPort


class OneStepDelay(Sampled):
    """Decode with the last force."""

    def _move(self, port: UserPort, body: Body, lost: Value) -> Value:
        before = port.xd_s
        port.xd_s = port.wave.velocity(port.u_s, port.f_s)
        lost = lost + port.contact.slide(self._old * before + self._new * port.xd_s)
        rate = port.xd_s - body.xd
        port.f_s = port.contact.force(rate)
        return lost + self._period * port.contact.heat(rate)


RECORD = Coupling(
    name="one_step_delay",
    words="Waves are decoded with the force of the step before: passive at a wall while "
    "K T_VE + 2 B <= b (backward Euler).",
    linear="one_step_delay",
    make=OneStepDelay,
    late=True,
    least_impedance=least_impedance,
)
