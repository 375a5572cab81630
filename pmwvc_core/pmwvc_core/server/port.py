# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The server's end of the wave channels: waves in, one step of the environment, waves out.

Decoding belongs to the coupling (it is the algebraic loop). Encoding is v_s = u_s - sqrt(2/b) f_s
for all of them, so that at a port whose xd_s was decoded with the same f_s, power balances: f_s
xd_s = (|u_s|^2 - |v_s|^2)/2.

Not here: packets, time, and what to do with bad input (``wave.receiver``).
"""

from collections.abc import Sequence

from pmwvc_core.numeric import Value, squared
from pmwvc_core.params import ServerParams
from pmwvc_core.server.couplings import COUPLINGS, Implicit
from pmwvc_core.server.environments import make_environment
from pmwvc_core.server.user_ports import Seat, ServerController


class WaveServer(ServerController):
    """Avatars behind wave ports around one object."""

    def __init__(self, params: ServerParams, seats: Sequence[Seat]) -> None:
        super().__init__(make_environment(params), seats)
        self._coupling = COUPLINGS[params.coupling](params)
        if isinstance(self._coupling, Implicit):
            self.trouble = self._coupling.faults
        self._half_period = 0.5 * params.period_s

    def step(self, received: Sequence[Value]) -> list[Value]:
        """Go one step on with a wave ``(..., dof)`` [sqrt(W)] per user; return waves to send."""
        seated: list[Seat] = []
        for seat, wave in zip(self.seats, received, strict=True):
            if seat.present:
                seat.u_s = wave
                seated.append(seat)
        self.dissipated = self.dissipated + self._coupling.step(seated, self.body)
        half_s = self._half_period
        for seat in seated:
            u_s = seat.u_s
            seat.v_s = v_s = u_s - seat.ratio * seat.f_s
            seat.x_s = self._place(seat)
            seat.energy_u_s = seat.energy_u_s + half_s * squared(u_s)
            seat.energy_v_s = seat.energy_v_s + half_s * squared(v_s)
        return self.v_s
