# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One frame late: a wave moves the avatar in the next step (App. B, Eq. 14).

The sign of f_s/b is corrected; as published the port would feed the force back into itself.

::

    f_s(n)    = K [x_s(n) - x_o(n)] + B [xd_s(n) - xd_o(n)]
    x_s(n+1)  = x_s(n) + h xd_s(n)                       forward Euler
    xd_s(n+1) = sqrt(2/b) u_s(n) - f_s(n)/b

then the object moves on from n to n+1, exactly under f_s(n) held. The answer is v_s(n) = u_s(n) -
sqrt(2/b) f_s(n). This is the scheme behind App. B, Fig. 2. After a step ``x_s`` and ``xd_s`` are
those of n+1, ``f_s`` is that of n.

Equations: docs/theory.md 4.7.
"""

from collections.abc import Sequence

from pmwvc_core.numeric import Value
from pmwvc_core.params import ServerParams
from pmwvc_core.server.couplings.record import Coupling, forward
from pmwvc_core.server.couplings.sampled import push_object
from pmwvc_core.server.cube import Body
from pmwvc_core.server.user_ports import UserPort


class OneFrameLate:
    """Decode now, move in the next step."""

    def __init__(self, params: ServerParams) -> None:
        self._period = params.period_s

    def step(self, ports: Sequence[UserPort], body: Body) -> Value:
        """Use every port's ``u_s``; return the energy dissipated [J]."""
        lost: Value = 0.0
        for port in ports:
            rate = port.xd_s - body.xd
            port.f_s = port.contact.force(rate)
            lost = lost + self._period * port.contact.heat(rate)
            lost = lost + port.contact.slide(self._period * port.xd_s)
            port.xd_s = port.wave.velocity(port.u_s, port.f_s)
        return lost + push_object(ports, body)


RECORD = Coupling(
    name="one_frame_late",
    words="A wave moves the avatar one step late: no bound of its energy is known.",
    linear="one_frame_late",
    make=OneFrameLate,
    moves=forward,
    object_motion="held",
)
