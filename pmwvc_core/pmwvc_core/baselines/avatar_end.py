# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The common part of the server's ends of all controllers without waves.

A step: the object has come here exactly under the last forces held; then every avatar meets it,
each by itself. ``energy_u_s`` is what flowed to the avatar, ``energy_v_s`` what came back, both
from f_s xd_s of the step.

Two ways to move an avatar: along the device (``direct``, ``tdpa``), or by a spring and a damper
from a set point, solved together with the contact (``virtual_coupling``, ``pspm``): see
:class:`SprungAvatarEnd`.
"""

from abc import abstractmethod
from collections.abc import Sequence

from pmwvc_core.numeric import Value, dot, maximum
from pmwvc_core.params import ServerParams
from pmwvc_core.server.controller import ServerController
from pmwvc_core.server.couplings.sampled import push_object
from pmwvc_core.server.environments import make_body
from pmwvc_core.server.user_ports import UserPort
from pmwvc_core.transport.packet import FLAG_DIRECT


class AvatarEnd(ServerController):
    """Avatars around one object; a controller adds how one moves, and another answer."""

    flags = FLAG_DIRECT

    def __init__(self, params: ServerParams, ports: Sequence[UserPort]) -> None:
        super().__init__(make_body(params), ports)
        self._period = params.period_s

    def step(self, received: Sequence[tuple[Value, Value]]) -> list[Value]:
        """Go one step on with position [m] and velocity [m/s] per user; return the answers."""
        self.dissipated = self.dissipated + push_object(self._present_ports(), self.body)
        for i, (port, report) in enumerate(zip(self.ports, received, strict=True)):
            if port.present:
                self._meet(i, *report)
        return [self._answer(port) if port.present else 0.0 for port in self.ports]

    @abstractmethod
    def _meet(self, i: int, position: Value, velocity: Value) -> None:
        """Move user i's avatar and form its force, given where the device was [m], [m/s]."""

    def _answer(self, port: UserPort) -> Value:
        """Return what goes back to a present user: the force [N]."""
        return port.f_s

    def _book(self, port: UserPort, rate: Value, lost: Value) -> None:
        """Book a step in which the contact had this relative velocity [m/s] and lost that [J]."""
        self.dissipated = self.dissipated + lost + self._period * port.contact.heat(rate)
        flow = self._period * dot(port.f_s, port.xd_s)
        port.energy_u_s = port.energy_u_s + maximum(flow, 0.0)
        port.energy_v_s = port.energy_v_s + maximum(-flow, 0.0)


class SprungAvatarEnd(AvatarEnd):
    """Avatars on springs; what goes back is their position."""

    def _answer(self, port: UserPort) -> Value:
        """Return where the avatar is, in the device's frame [m]."""
        return port.x_s - port.offset

    def _pull(
        self, port: UserPort, set_point: Value, velocity: Value, stiffness: Value, damping: Value
    ) -> None:
        """Let spring and damper pull the avatar against its contact (backward Euler).

        ::

            f_s = K (p - x_s - h xd_s) + B (velocity - xd_s),   x_s += h xd_s

        is xd_s = free - f_s/Z with Z = K h + B: solved as at a wave port, with the object as
        sampled.
        """
        h = self._period
        impedance = stiffness * h + damping
        free = (stiffness * (set_point - port.x_s) + damping * velocity) / impedance
        port.f_s = port.contact.unwrapped(free, self.body.xd, impedance, h)
        port.xd_s = free - port.f_s / impedance
        lost = port.contact.slide(h * port.xd_s)
        port.x_s = self.body.x + port.contact.position
        self._book(port, port.xd_s - self.body.xd, lost)
