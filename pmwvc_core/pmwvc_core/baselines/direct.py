# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Direct coupling: position and velocity go up each frame, the contact force comes back, held.

What networked haptics did before wave variables, and what App. B compares with (Fig. 3). It is not
passive: the force is as old as the way there and back.

::

    f_s(n) = K [x_m + offset - x_o(n)] + B [xd_m - xd_o(n)],    F_m = f_s as last received
"""

from pmwvc_core.baselines.avatar_end import AvatarEnd
from pmwvc_core.baselines.device_end import DeviceEnd
from pmwvc_core.numeric import Value


class DirectServer(AvatarEnd):
    """Avatars that stand where the devices stood when they last reported.

    ``xd_s`` is the velocity as reported.
    """

    def _meet(self, i: int, position: Value, velocity: Value) -> None:
        """Put the avatar where the device is and form the force."""
        port = self.ports[i]
        x_s = position + port.offset
        lost = port.contact.slide(x_s - (self.body.x + port.contact.position))
        port.x_s, port.xd_s = x_s, velocity
        rate = velocity - self.body.xd
        port.f_s = port.contact.force(rate)
        self._book(port, rate, lost)


class DirectMaster(DeviceEnd):
    """The device's end: send where it is, apply the force as last received."""

    SIGNALS = "_force"

    def __init__(self, *, tick_s: float) -> None:
        super().__init__(tick_s=tick_s)
        self._force: Value = 0.0

    def receive(self, wave: Value) -> None:
        """Take the newest force [N]."""
        self._force = wave

    def silence(self) -> None:
        """Let go: no force until the next answer."""
        self._force = 0.0 * self._force

    def step(self, x: Value, xd: Value) -> Value:
        """Return the held force [N]."""
        self.measure(x, xd)
        return self._force
