# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What the server's ends of all controllers without waves have in common.

A step: the object has come here exactly under the last forces held; then every avatar meets it,
each by itself. ``energy_u_s`` is what flowed to the avatar, ``energy_v_s`` what came back, both
from f_s xd_s of the step.

Two ways to move an avatar: along the device (``direct``, ``tdpa``), or by a spring and a damper
from a set point, solved together with the contact (``virtual_coupling``, ``pspm``).
"""

from abc import abstractmethod
from collections.abc import Sequence

from pmwvc_core.numeric import Value, dot, maximum
from pmwvc_core.params import ServerParams
from pmwvc_core.server.couplings.sampled import push_object
from pmwvc_core.server.environments import make_environment
from pmwvc_core.server.user_ports import Seat, ServerController
from pmwvc_core.transport.packet import FLAG_DIRECT


class AvatarEnd(ServerController):
    """Avatars around one object; a controller adds how one moves and what goes back."""

    flags = FLAG_DIRECT

    def __init__(self, params: ServerParams, seats: Sequence[Seat]) -> None:
        super().__init__(make_environment(params), seats)
        self._period = params.period_s

    def step(self, received: Sequence[tuple[Value, Value]]) -> list[Value]:
        """Go one step on with position [m] and velocity [m/s] per user; return the answers."""
        self.dissipated = self.dissipated + push_object(self._seated(), self.body)
        for i, (seat, report) in enumerate(zip(self.seats, received, strict=True)):
            if seat.present:
                self._meet(i, *report)
        return [self._answer(seat) if seat.present else 0.0 for seat in self.seats]

    @abstractmethod
    def _meet(self, i: int, position: Value, velocity: Value) -> None:
        """Move user i's avatar and form its force, given where the device was [m], [m/s]."""

    @abstractmethod
    def _answer(self, seat: Seat) -> Value:
        """Return what goes back to a seated user."""

    def _pull(
        self, seat: Seat, set_point: Value, velocity: Value, stiffness: Value, damping: Value
    ) -> None:
        """Let spring and damper pull the avatar against its contact (backward Euler).

        ::

            f_s = K (p - x_s - h xd_s) + B (velocity - xd_s),   x_s += h xd_s

        is xd_s = free - f_s/Z with Z = K h + B: solved as at a wave port, with the object as
        sampled.
        """
        h = self._period
        impedance = stiffness * h + damping
        free = (stiffness * (set_point - seat.x_s) + damping * velocity) / impedance
        seat.f_s = seat.contact.unwrapped(free, self.body.xd, impedance, h)
        seat.xd_s = free - seat.f_s / impedance
        lost = seat.contact.slide(h * seat.xd_s)
        seat.x_s = self._place(seat)
        self._book(seat, seat.xd_s - self.body.xd, lost)

    def _book(self, seat: Seat, rate: Value, lost: Value) -> None:
        """Book a step in which the contact had this relative velocity [m/s] and lost that [J]."""
        self.dissipated = self.dissipated + lost + self._period * seat.contact.heat(rate)
        flow = self._period * dot(seat.f_s, seat.xd_s)
        seat.energy_u_s = seat.energy_u_s + maximum(flow, 0.0)
        seat.energy_v_s = seat.energy_v_s + maximum(-flow, 0.0)
