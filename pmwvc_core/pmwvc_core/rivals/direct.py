# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Direct coupling: position and velocity go up each frame, the contact force comes back, held.

What networked haptics did before wave variables, and what App. B compares with (Fig. 3). It is not
passive: the force is as old as the way there and back.

::

    f_s(n) = K [x_m + offset - x_o(n)] + B [xd_m - xd_o(n)],    F_m = f_s as last received

Master and server keep their accounts in the same places as the wave controllers do:
``energy_u_...`` is what flowed from the hand towards the object, ``energy_v_...`` what flowed
back, both from force times velocity at that port. The wave signals themselves are zero.
"""

from collections.abc import Sequence

from pmwvc_core.numeric import Value, dot, maximum
from pmwvc_core.params import MasterParams, ServerParams
from pmwvc_core.server.couplings.sampled import push_object
from pmwvc_core.server.environments import make_environment
from pmwvc_core.server.seats import NO_ACCOUNTS, Seat, ServerController
from pmwvc_core.wave.packet import FLAG_DIRECT, WavePacket


class DirectServer(ServerController):
    """Avatars that stand where the devices stood when they last reported.

    Before that the object has come here exactly, under the last forces held. ``xd_s`` is the
    velocity as reported.
    """

    flags = FLAG_DIRECT

    def __init__(self, params: ServerParams, seats: Sequence[Seat]) -> None:
        super().__init__(make_environment(params), seats)
        self._period = params.period_s

    def step(self, received: Sequence[tuple[Value, Value]]) -> list[Value]:
        """Go one step on with position [m] and velocity [m/s] per user; return the forces [N]."""
        self.dissipated = self.dissipated + push_object(self._seated(), self.body)
        for seat, report in zip(self.seats, received, strict=True):
            if seat.present:
                self._meet(seat, *report)
        return self.f_s

    def _meet(self, seat: Seat, position: Value, velocity: Value) -> None:
        """Put the avatar where the device is and form the force."""
        place = position + seat.offset
        lost = seat.contact.slide(place - self._place(seat))
        seat.x_s, seat.xd_s = place, velocity
        rate = velocity - self.body.xd
        seat.f_s = seat.contact.force(rate)
        self.dissipated = self.dissipated + lost + self._period * seat.contact.heat(rate)
        flow = self._period * dot(seat.f_s, velocity)
        seat.energy_u_s = seat.energy_u_s + maximum(flow, 0.0)
        seat.energy_v_s = seat.energy_v_s + maximum(-flow, 0.0)


class DirectMaster:
    """The device's end: send where it is, apply the force as last received.

    Parameters
    ----------
    tick_s : float
        Period of the force loop [s].
    """

    flags = FLAG_DIRECT
    u_m: Value = 0.0
    u_m_lp: Value = 0.0
    v_m: Value = 0.0
    accounts = NO_ACCOUNTS

    def __init__(self, *, tick_s: float) -> None:
        self._tick_s = tick_s
        self._force: Value = 0.0
        self._x: Value = 0.0
        self._xd: Value = 0.0
        self.energy_u_m: Value = 0.0  # [J] from the device into the controller
        self.energy_v_m: Value = 0.0  # [J] from the controller into the device

    @property
    def energy_u_tx(self) -> Value:
        """As ``energy_u_m``: packets carry no energy of their own."""
        return self.energy_u_m

    @property
    def energy_v_rx(self) -> Value:
        """As ``energy_v_m``."""
        return self.energy_v_m

    def configure(self, params: MasterParams) -> None:
        """Nothing to take over: this controller has no parameters of its own."""

    def hear(self, packet: WavePacket) -> None:
        """Nothing to note: the force is all that counts."""

    def account(self) -> None:
        """Keep no energy of its own."""

    def receive(self, wave: Value) -> None:
        """Take the newest force [N]."""
        self._force = wave

    def measure(self, x: Value, xd: Value) -> None:
        """Note position [m] and velocity [m/s] at a frame start, before ``send``."""
        self._x, self._xd = x, xd

    def step(self, x: Value, xd: Value) -> Value:
        """Return the held force [N]."""
        self.measure(x, xd)
        return self._force

    def applied(self, f: Value) -> None:
        """Book the force [N] that safety let through."""
        energy = self._tick_s * dot(f, self._xd)
        self.energy_u_m = self.energy_u_m + maximum(energy, 0.0)
        self.energy_v_m = self.energy_v_m + maximum(-energy, 0.0)

    def send(self) -> Value:
        """Return the velocity [m/s] last measured."""
        return self._xd

    def position(self) -> Value:
        """Return the position [m] last measured."""
        return self._x

    def silence(self) -> None:
        """Let go: no force until the next answer."""
        self._force = 0.0 * self._force
