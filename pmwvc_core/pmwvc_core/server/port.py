# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The server's end of the wave channels: waves in, one step of the environment, waves out.

Decoding belongs to the coupling (it is the algebraic loop). Encoding is v_s = u_s - sqrt(2/b) f_s
for all of them, so that at a port whose xd_s was decoded with the same f_s, power balances: f_s
xd_s = (|u_s|^2 - |v_s|^2)/2.

Not here: packets, time, and what to do with bad input (``wave.receiver``).
"""

from collections.abc import Callable, Sequence

from pmwvc_core.errors import ParameterError
from pmwvc_core.numeric import Value, squared
from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.server.couplings import COUPLINGS
from pmwvc_core.server.environments import make_environment
from pmwvc_core.server.factory import make_seats
from pmwvc_core.server.seats import Seat, ServerController

__all__ = ["SERVERS", "ServerController", "WaveServer", "make_server"]


class WaveServer(ServerController):
    """Avatars behind wave ports around one object."""

    def __init__(self, params: ServerParams, seats: Sequence[Seat]) -> None:
        super().__init__(make_environment(params), seats)
        self._coupling = COUPLINGS[params.coupling](params)
        self._half_period = 0.5 * params.period_s

    def step(self, received: Sequence[Value]) -> list[Value]:
        """Go one step on with a wave ``(..., dof)`` [sqrt(W)] per user; return waves to send."""
        for seat, wave in zip(self.seats, received, strict=True):
            if seat.present:
                seat.u_s = wave
        seated = self._seated()
        lost = self._coupling.step(seated, self.body)
        self.dissipated = self.dissipated + lost
        for seat in seated:
            seat.v_s = seat.u_s - seat.ratio * seat.f_s
            seat.x_s = self._place(seat)
            seat.energy_u_s = seat.energy_u_s + self._half_period * squared(seat.u_s)
            seat.energy_v_s = seat.energy_v_s + self._half_period * squared(seat.v_s)
        return self.v_s


# By the name of the controller; ``controllers`` adds what is built from more than this package.
SERVERS: dict[str, Callable[[ServerParams, Sequence[Seat]], ServerController]] = {
    "pmwvc": WaveServer
}


def make_server(
    controller: str,
    server: ServerParams,
    contacts: Sequence[ContactParams],
    impedances: Sequence[Value],
    *,
    dof: int,
    sides: Sequence[int],
) -> ServerController:
    """Return the server end of a controller by name, with nobody seated.

    Parameters
    ----------
    controller : str
        A name in ``SERVERS``.
    server : ServerParams
    contacts : sequence of ContactParams
        One per user.
    impedances : sequence of Value
        Wave impedance of each user's master [N s/m]: used where the contact names none of its own.
    dof : int
        Number of axes.
    sides : sequence of int
        -1 (left of the object) or +1 (right), one per user.
    """
    if controller not in SERVERS:
        raise ParameterError(f"controller = {controller!r}: must be one of {', '.join(SERVERS)}")
    seats = make_seats(server, contacts, impedances, dof=dof, sides=sides)
    return SERVERS[controller](server, seats)
