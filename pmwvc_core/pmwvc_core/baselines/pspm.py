# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Passive set-position modulation (Lee and Huang 2010): device and avatar hang on set points that
follow each other as far as energy allows.

::

    F_m = B xd_m + K (x_m - q_m),    f_s = K (q_s - x_s) - B xd_s

q_m goes towards the avatar and q_s towards the device, as last received; how far, see
:class:`ModulatedSpring`. B damps to ground, and what it turns to heat pays for the next moves.
Neither end ever gives out more than it had, took in and received: passive with any delay, loss and
order of packets, for B > K T_c/2 at the device (its spring is held over a tick; at the server
force and motion are solved together). The price is B, felt at both ends.

With x where an end is and q its set point, the spring K |x - q|^2/2 gains, when q moves to q',

    dE = K/2 (|x - q'|^2 - |x - q|^2)

This comes out of a tank; q' is the point nearest to the wanted one on the straight way there that
the tank can pay for. The tank is filled by what the damper of this end turns to heat, and by what
the peer sends; above a cap the rest goes to the peer.

Lee and Huang bound the damper's heat from below by positions, b (x_max - x_min)^2/dt. Here the
work done at the port in a tick is known: what has been put in and is not in the spring went to the
damper. For one tick and b = B - K dt/2 that is their bound, but for the acceleration within the
tick; it stays right where safety changes the force. Work, tank and spring add up::

    work put in + received = spring + (tank - initial) + sent + dropped

A tank below zero (a force that safety changed, a spring too stiff for its tick) moves the set
point only where that pays the tank back.
"""

from collections.abc import Mapping, Sequence

from pmwvc_core.account import Entry, Role
from pmwvc_core.baselines.avatar_end import SprungAvatarEnd
from pmwvc_core.baselines.device_end import Arrivals, DeviceEnd
from pmwvc_core.numeric import Value, clip, dot, maximum, root, squared, where
from pmwvc_core.params import ServerParams
from pmwvc_core.params.baselines import PspmParams
from pmwvc_core.server.user_ports import UserPort
from pmwvc_core.state import Stateful
from pmwvc_core.transport.packet import WavePacket

ENTRIES = TANK, SPRING = (
    Entry("pspm_tank", "energy tank of the set points", Role.LEVEL),
    Entry("pspm_spring", "springs to the set points", Role.LEVEL),
)


class PspmServer(SprungAvatarEnd):
    """Avatars on modulated set points."""

    BLOCKS = "springs"

    def __init__(self, params: ServerParams, ports: Sequence[UserPort]) -> None:
        super().__init__(params, ports)
        self.springs = [ModulatedSpring(port.baseline.pspm) for port in ports]

    @property
    def accounts(self) -> Mapping[str, Value]:
        """Of all users together."""
        return {
            TANK.name: sum((each.tank for each in self.springs), 0.0),
            SPRING.name: sum((each.spring for each in self.springs), 0.0),
        }

    def join(self, i: int, position: Value) -> None:
        """Let a user join with the set point at the avatar."""
        super().join(i, position)
        self.springs[i].let_go(self.ports[i].x_s)

    def _meet(self, i: int, position: Value, velocity: Value) -> None:
        """Move the set point, then the avatar."""
        port, spring = self.ports[i], self.springs[i]
        params = port.baseline.pspm
        if port.packet is not None:
            spring.on_packet(port.packet)
        spring.aim(position + port.offset, port.x_s)
        self._pull(port, spring.q, 0.0, params.stiffness, params.damping)
        spring.moved(port.x_s, -self._period * dot(port.f_s, port.xd_s))
        spring.divide()
        port.account = spring.sent


class PspmMaster(DeviceEnd):
    """The device's end: spring, damper and tank; parameters may be ``(runs, 1)``."""

    BLOCKS = "spring"
    SIGNALS = "_force"
    MEMORY = "_coupled"

    def __init__(self, params: PspmParams, *, tick_s: float) -> None:
        super().__init__(tick_s=tick_s)
        self.spring = ModulatedSpring(params)
        self._stiffness = params.stiffness
        self._damping = params.damping
        self._force: Value = 0.0  # [N] as applied
        self._coupled = False

    @property
    def accounts(self) -> Mapping[str, Value]:
        """Energy of this end by account [J]."""
        return {TANK.name: self.spring.tank, SPRING.name: self.spring.spring}

    def account(self) -> Value:
        """Send the sum of what was above the cap."""
        return self.spring.sent

    def on_packet(self, packet: WavePacket) -> None:
        """Take in what the server sent."""
        self.spring.on_packet(packet)

    def receive(self, wave: Value) -> None:
        """Move the set point towards the avatar [m]."""
        self._coupled = True
        self.spring.aim(wave, self._x)

    def silence(self) -> None:
        """Let go: no force until the next answer."""
        self._coupled = False
        self.spring.let_go(self._x)

    def measure(self, x: Value, xd: Value) -> None:
        """Note the motion; the force applied last has done its work until here."""
        before = self._x
        super().measure(x, xd)
        if not self._coupled:
            self.spring.q = self._x
        self.spring.moved(self._x, dot(self._force, self._x - before))

    def send(self) -> Value:
        """Divide the tank, then return the velocity [m/s]."""
        self.spring.divide()
        return super().send()

    def step(self, x: Value, xd: Value) -> Value:
        """Return B xd + K (x - q) [N]."""
        self.measure(x, xd)
        if not self._coupled:
            return 0.0 * self._x
        return self._damping * self._xd + self._stiffness * (self._x - self.spring.q)

    def applied(self, f: Value) -> None:
        """Note the force [N] that safety let through."""
        super().applied(f)
        self._force = f


class ModulatedSpring(Stateful):
    """Set point, tank and shuffled sum of one end; parameters may be ``(runs, 1)``."""

    BLOCKS = "_arrivals"
    SIGNALS = "q"
    MEMORY = "tank spring sent received dropped"

    def __init__(self, params: PspmParams) -> None:
        self._stiffness = params.stiffness
        self._cap = params.cap_j
        self.q: Value = 0.0  # [m] set point
        self.tank: Value = params.initial_j  # [J]
        self.spring: Value = 0.0  # [J]
        self.sent: Value = 0.0  # [J] running sum, goes into the packets
        self.received: Value = 0.0  # [J]
        self.dropped: Value = 0.0  # [J] springs let go
        self._arrivals = Arrivals()

    def on_packet(self, packet: WavePacket) -> None:
        """Take in what the peer sent."""
        gained = self._arrivals.take(packet)
        self.received = self.received + gained
        self.tank = self.tank + gained

    def moved(self, x: Value, work: Value) -> None:
        """Take note that this end came to x [m] while this work was put in at its port [J]."""
        spring = 0.5 * self._stiffness * squared(x - self.q)
        self.tank = self.tank + work - (spring - self.spring)
        self.spring = spring

    def aim(self, wanted: Value, x: Value) -> None:
        """Move the set point towards a wanted one [m], as far as the tank allows.

        The ratio s of the way w costs K/2 (s^2 |w|^2 - 2 s w . (x - q)).
        """
        way, stretch = wanted - self.q, x - self.q
        length, along = squared(way), dot(way, stretch)
        within = maximum(along * along + 2.0 * length * self.tank / self._stiffness, 0.0)
        ratio = clip((along + root(within)) / where(length > 0.0, length, 1.0), 0.0, 1.0)
        self.q = self.q + ratio * way
        spring = 0.5 * self._stiffness * squared(x - self.q)
        self.tank = self.tank - (spring - self.spring)
        self.spring = spring

    def divide(self) -> None:
        """Send the peer what is above the cap."""
        excess = maximum(self.tank - self._cap, 0.0)
        self.tank = self.tank - excess
        self.sent = self.sent + excess

    def let_go(self, x: Value) -> None:
        """Put the set point where this end is; what the spring holds is dropped."""
        self.q = x
        self.dropped = self.dropped + self.spring
        self.spring = 0.0 * self.spring
