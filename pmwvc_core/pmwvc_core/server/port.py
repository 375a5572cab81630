# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The server's end of the wave channels: waves in, one step of the environment, waves out.

An avatar that joined at the face, with its device inside the object, slides to it once there is
room, by a change of the mapping between the two of at most ``SLIDE_M_S``::

    offset <- offset + w h,   x_s <- x_s + w h,   where the avatar is outside before and after

A contact stores nothing there (phi(p) = 0 for p <= 0); waves, forces and xd_s of the step stay
what they are. So no energy comes or goes, and the device receives nothing of it.

Decoding belongs to the coupling (it is the algebraic loop). Encoding is v_s = u_s - sqrt(2/b) f_s
for all of them, so that at a port whose xd_s was decoded with the same f_s, power balances: f_s
xd_s = (|u_s|^2 - |v_s|^2)/2.

Not here: packets, time, and what to do with bad input (``wave.receiver``).

Equations: docs/theory.md 17.20.
"""

from collections.abc import Sequence

from pmwvc_core.account import Passage
from pmwvc_core.numeric import Value, anywhere, limit_length
from pmwvc_core.params import ServerParams
from pmwvc_core.server.controller import ServerController
from pmwvc_core.server.couplings import COUPLINGS, Faulting
from pmwvc_core.server.couplings.contained import solver_of
from pmwvc_core.server.environments import make_body
from pmwvc_core.server.user_ports import UserPort

SLIDE_M_S = 0.1
# Between the waves at all ports and the work of the forces at the avatars.
DECODING = Passage("late_decoding", ("ports",), ("avatars",))


class WaveServer(ServerController):
    """Avatars behind wave ports around one object."""

    def __init__(self, params: ServerParams, ports: Sequence[UserPort]) -> None:
        super().__init__(make_body(params), ports)
        self._couple(params)

    def _couple(self, params: ServerParams) -> None:
        self._coupling = params.coupling, params.integrator, params.period_s
        self._half_period = 0.5 * params.period_s
        self._solver = solver_of(COUPLINGS.of(params.coupling), params)
        self.faults = self._solver.faults if isinstance(self._solver, Faulting) else None

    def configure(self, params: ServerParams) -> None:
        """Take other parameters over; another coupling, or one of another period, goes on from
        forces and velocities as they are.
        """
        super().configure(params)
        wanted = params.coupling, params.integrator, params.period_s
        if wanted[:2] != self._coupling[:2]:
            self._couple(params)
        elif wanted != self._coupling:
            before = self.faults
            self._couple(params)
            if before and self.faults:
                self.faults.restore(before.snapshot())

    def step(self, received: Sequence[Value]) -> list[Value]:
        """Go one step on with a wave ``(..., dof)`` [sqrt(W)] per user; return waves to send."""
        present: list[UserPort] = []
        for port, wave in zip(self.ports, received, strict=True):
            if port.present:
                port.take(wave)
                present.append(port)
        self.dissipated = self.dissipated + self._solver.step(present, self.body)
        for port in present:
            port.give(port.wave.v(port.u_s, port.f_s), self._half_period)
            if anywhere(port.offset != 0.0):
                self._slide(port)
            port.x_s = self.body.x + port.contact.position
        return [port.v_s for port in self.ports]

    def _slide(self, port: UserPort) -> None:
        """Bring an avatar that touches nothing closer to its device."""
        most_m = 2.0 * self._half_period * SLIDE_M_S
        moved = port.contact.clear(limit_length(-port.offset, most_m))
        self.dissipated = self.dissipated + port.contact.slide(moved)
        port.offset = port.offset + moved
