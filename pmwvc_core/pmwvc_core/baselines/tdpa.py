# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Time-domain passivity observer and controller for a two-port with delay (Hannaford and Ryu 2002;
Ryu, Artigas and Preusche 2010).

The device sends its velocity, the server its contact force. Both ends count what flows into and
out of the link at their port, P = f . velocity against the link,

    E_in += max(P, 0) h,    E_out += max(-P, 0) h

and send E_in. An end may give out what the other is known to have put in:

    allowance = E_in of the other, as received, - E_out + what its controller has dissipated

Where the next step would overdraw it by dE, the controller dissipates dE: at the device by a
damper (impedance type), at the avatar by giving way (admittance type),

    F += a xd,   a = min(dE/(h |xd|^2), damping_max),        xd_s -= (dE/(h |f|^2)) f

At the device the work of a tick is counted when done, f_{k-1} . (x_k - x_{k-1}): the force is
held while the velocity changes, and with an encoder the velocity at the tick belongs to the way
before. The damper is chosen from the velocity at the tick and can fall short (at rest, at its
limit, by what the velocity changes); what is missing stays in the observer and is dissipated
later. The damper fades over ``fade_s`` instead of switching off at each tick, which limits its
chatter. Giving way makes avatar and device drift apart; the drift is made up by a share per step,
under the same observer (after Coelho et al. 2019).
"""

from collections.abc import Mapping, Sequence

from pmwvc_core.account import Entry, Role
from pmwvc_core.baselines.avatar_end import AvatarEnd
from pmwvc_core.baselines.device_end import Arrivals
from pmwvc_core.baselines.direct import DirectMaster
from pmwvc_core.numeric import Value, dot, maximum, minimum, squared, where
from pmwvc_core.params import ServerParams
from pmwvc_core.params.baselines import TdpaParams
from pmwvc_core.server.user_ports import UserPort
from pmwvc_core.state import Stateful
from pmwvc_core.transport.packet import WavePacket

PART = "passivity controller"
ENTRIES = DISSIPATED, ALLOWANCE = (
    Entry("tdpa_dissipated", "dissipated by the passivity controller", Role.TAKEN, part=PART),
    Entry("tdpa_allowance", "energy that may still be released", Role.LEVEL),
)
LEAST = 1e-30  # [m^2/s^2] or [N^2]: a square below it is nothing to divide by


class Observer(Stateful):
    """The energy of one end of the link [J]."""

    BLOCKS = "_arrivals"
    MEMORY = "energy_in energy_out dissipated allowance"

    def __init__(self) -> None:
        self.energy_in: Value = 0.0
        self.energy_out: Value = 0.0
        self.dissipated: Value = 0.0  # by the passivity controller
        self.allowance: Value = 0.0  # what may still be given out
        self._arrivals = Arrivals()

    def on_packet(self, packet: WavePacket) -> None:
        """Take in what the other end reports."""
        self.allowance = self.allowance + self._arrivals.take(packet)

    def overdraft(self, energy: Value) -> Value:
        """Return how much too much it would be to give out an energy (negative: take in) [J]."""
        return maximum(maximum(energy, 0.0) - self.allowance, 0.0)

    def book(self, energy: Value, dissipated: Value) -> None:
        """Book what a step gave out (negative: took in), the dissipation of the controller left
        out of it, and that.
        """
        given = maximum(energy, 0.0)
        self.energy_in = self.energy_in + maximum(-energy, 0.0)
        self.energy_out = self.energy_out + given
        self.dissipated = self.dissipated + dissipated
        self.allowance = self.allowance - given + dissipated


class TdpaServer(AvatarEnd):
    """Avatars that move at the devices' velocities, as far as energy allows.

    ``xd_s`` is the velocity with which the avatar goes on until the next step, under the force f_s
    held, so f_s xd_s h is the work that leaves the link.
    """

    BLOCKS = "observers"

    def __init__(self, params: ServerParams, ports: Sequence[UserPort]) -> None:
        super().__init__(params, ports)
        self.observers = [Observer() for _ in ports]

    @property
    def accounts(self) -> Mapping[str, Value]:
        """Of all users together."""
        return {
            DISSIPATED.name: sum((each.dissipated for each in self.observers), 0.0),
            ALLOWANCE.name: sum((each.allowance for each in self.observers), 0.0),
        }

    def _meet(self, i: int, position: Value, velocity: Value) -> None:
        """Arrive where the last step led, form the force, choose the velocity from here."""
        port, observer, h = self.ports[i], self.observers[i], self._period
        if port.packet is not None:
            observer.on_packet(port.packet)
        lost = port.contact.slide(h * port.xd_s)
        port.x_s = self.body.x + port.contact.position
        port.f_s = f = port.contact.force(velocity - self.body.xd)
        excess = observer.overdraft(h * dot(f, velocity))
        lag = position + port.offset - port.x_s
        drift = lag * (port.baseline.tdpa.drift_share / h)
        port.xd_s = self._within(observer, f, velocity + drift)
        observer.book(h * dot(f, port.xd_s), 0.0)
        observer.dissipated = observer.dissipated + excess
        port.account = observer.energy_in
        self._book(port, velocity - self.body.xd, lost)

    def _within(self, observer: Observer, f: Value, velocity: Value) -> Value:
        """Return the velocity nearest to the one wanted [m/s] that gives out no more than may be
        given out.
        """
        h, size = self._period, squared(f)
        excess = observer.overdraft(h * dot(f, velocity))
        given_way = f * (excess / (h * where(size > LEAST, size, 1.0)))
        return where(size > LEAST, velocity - given_way, velocity)


class TdpaMaster(DirectMaster):
    """The device's end: the force as last received, and a damper where that would give out more
    than the server put in. Parameters may be ``(runs, 1)``.
    """

    BLOCKS = "observer"
    SIGNALS = "_held"
    MEMORY = "_damping _braked"

    def __init__(self, params: TdpaParams, *, tick_s: float) -> None:
        super().__init__(tick_s=tick_s)
        self.observer = Observer()
        self._local = params.damping
        self._damping_max = params.damping_max
        rate = tick_s / where(params.fade_s > 0.0, params.fade_s, 1.0)
        self._kept = where(params.fade_s > 0.0, 1.0 / (1.0 + rate), 0.0)  # of a damping, by a tick
        self._damping: Value = 0.0
        self._held: Value = 0.0  # [N] on the device since the last tick, as safety let it through
        self._braked: Value = 0.0  # [N s/m] of the controller's damper in it

    @property
    def accounts(self) -> Mapping[str, Value]:
        """Energy dissipated by the controller, and energy it may still give out [J]."""
        return {DISSIPATED.name: self.observer.dissipated, ALLOWANCE.name: self.observer.allowance}

    def account(self) -> Value:
        """Send what went into the link at this end."""
        return self.observer.energy_in

    def on_packet(self, packet: WavePacket) -> None:
        """Take in what the server reports."""
        self.observer.on_packet(packet)

    def step(self, x: Value, xd: Value) -> Value:
        """Return the held force and that of both dampers [N]."""
        self.measure(x, xd)
        square = squared(self._xd)
        excess = self.observer.overdraft(-self._tick_s * dot(self._force, self._xd))
        needed = excess / (self._tick_s * where(square > LEAST, square, 1.0))
        needed = where(square > LEAST, minimum(needed, self._damping_max), 0.0)
        self._damping = maximum(needed, self._damping * self._kept)
        return self._force + (self._local + self._damping) * self._xd

    def measure(self, x: Value, xd: Value) -> None:
        """Note the motion, and book the work of the force held until here; the local damper is
        not the link's.
        """
        before, velocity = self._x, self._xd
        super().measure(x, xd)
        way = self._x - before
        drag = dot(velocity, way)
        dissipated = self._braked * drag
        given = dissipated + self._local * drag - dot(self._held, way)
        self.observer.book(given, dissipated)
        self._held, self._braked = self._held * 0.0, 0.0

    def applied(self, f: Value) -> None:
        """Note the force that safety let through [N]."""
        super().applied(f)
        self._held, self._braked = f, self._damping
