# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Passive set-position modulation (Lee and Huang 2010): device and avatar hang on set points that
follow each other as far as energy allows.

::

    F_m = B xd_m + K (x_m - q_m),    f_s = K (q_s - x_s) - B xd_s

q_m goes towards the avatar and q_s towards the device, as last received; how far, see
:mod:`.modulated_spring`. B damps to ground, and what it turns to heat pays for the next moves.
Neither end ever gives out more than it had, took in and received: passive with any delay, loss and
order of packets, for B > K T_c/2 at the device (its spring is held over a tick; at the server
force and motion are solved together). The price is B, felt at both ends.
"""

from collections.abc import Mapping, Sequence

from pmwvc_core.account import Entry, Role
from pmwvc_core.baselines.avatar_end import AvatarEnd
from pmwvc_core.baselines.device_end import DeviceEnd
from pmwvc_core.baselines.modulated_spring import ModulatedSpring
from pmwvc_core.numeric import Value, dot
from pmwvc_core.params import ServerParams
from pmwvc_core.params.baselines import PspmParams
from pmwvc_core.server.user_ports import UserPort
from pmwvc_core.transport.packet import WavePacket

ENTRIES = TANK, SPRING = (
    Entry("pspm_tank", "energy tank of the set points", Role.LEVEL),
    Entry("pspm_spring", "springs to the set points", Role.LEVEL),
)


class PspmServer(AvatarEnd):
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

    def _answer(self, port: UserPort) -> Value:
        """Return where the avatar is, in the device's frame [m]."""
        return port.x_s - port.offset


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
