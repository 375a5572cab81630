# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Virtual coupling: spring and damper between device and avatar, at 1 kHz on the device's side
(Colgate, Stanley and Brown 1995; Adams and Hannaford 1999).

Each end renders the same spring and damper against the last received state of the other::

    F_m = K_c (x_m - p) + B_c (xd_m - p')          p: avatar, in the device's frame, as received
    f_s = K_c (x_m - p) + B_c (xd_m - p')          x_m: device, as received

The avatar has no mass: f_s is also what its contact bears. p' is the avatar's mean velocity
between the last two packets. Passive without delay where the device's damping b exceeds
K_c T_c/2 + B_c; with delays T_1 + T_2 around the loop K_c (T_1 + T_2)/2 <= B_c + b is asked for.
Neither rule excludes generated energy: no account bounds it.
"""

from pmwvc_core.baselines.avatar_end import SprungAvatarEnd
from pmwvc_core.baselines.device_end import DeviceEnd
from pmwvc_core.numeric import Value
from pmwvc_core.params.baselines import VirtualCouplingParams
from pmwvc_core.transport.packet import WavePacket


class VirtualCouplingServer(SprungAvatarEnd):
    """Avatars that hang on the devices by spring and damper."""

    def _meet(self, i: int, position: Value, velocity: Value) -> None:
        """Pull the avatar towards the device."""
        port = self.ports[i]
        coupling = port.baseline.virtual_coupling
        x_s = position + port.offset
        self._pull(port, x_s, velocity, coupling.stiffness, coupling.damping)


class VirtualCouplingMaster(DeviceEnd):
    """The device's end: a spring and a damper to the avatar as last reported; parameters may be
    ``(runs, 1)``.
    """

    SIGNALS = "_p _pd"
    MEMORY = "_coupled"

    def __init__(self, params: VirtualCouplingParams, *, tick_s: float) -> None:
        super().__init__(tick_s=tick_s)
        self._stiffness = params.stiffness
        self._damping = params.damping
        self._p: Value = 0.0  # [m]
        self._pd: Value = 0.0  # [m/s]
        self._coupled = False

    def on_packet(self, packet: WavePacket) -> None:
        """Take the avatar's velocity from the way it went since the packet before."""
        before = self._newest
        super().on_packet(packet)
        if before is None or before.epoch != packet.epoch or not self._coupled:
            self._pd = 0.0 * packet.wave
        elif packet.seq > before.seq:
            span_s = packet.period * (packet.seq - before.seq)
            self._pd = (packet.wave - self._p) / span_s

    def receive(self, wave: Value) -> None:
        """Take the avatar's position [m]."""
        self._p = wave
        self._coupled = True

    def silence(self) -> None:
        """Let go: no force until the next answer."""
        self._coupled = False

    def step(self, x: Value, xd: Value) -> Value:
        """Return K_c (x - p) + B_c (xd - p') [N]."""
        self.measure(x, xd)
        if not self._coupled:
            return 0.0 * self._x
        return self._stiffness * (self._x - self._p) + self._damping * (self._xd - self._pd)
