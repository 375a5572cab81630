# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One user's end in the linear model: what happens between the packets."""

from collections.abc import Mapping

import numpy as np
from oracle.linear_model.around import Feedback, LessVelocity, make_parts
from oracle.linear_model.blocks import Block, Device, Hold, Kept, column
from oracle.linear_model.filters import make_filter

from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import User


class WavePort:
    """Waves: filter, hold and device, and what stands in between.

    Parameters
    ----------
    user
        Parameters; numbers may be columns.
    tick_s
        Period of the force loop [s].
    phase
        Tick of the frame at which an answer is taken.
    """

    drifts: bool = True  # a uniform motion needs no force
    signals: tuple[str, ...] = ("u",)

    def __init__(self, user: User, *, tick_s: float, phase: int) -> None:
        master = user.master
        self._b = column(master.impedance)
        self._root = np.sqrt(2.0 * self._b)
        self.device = Device(user.device, tick_s=tick_s)
        self.filter = make_filter(master.filter, tick_s=tick_s, rate_drop=master.rate_drop)
        self.hold = Hold(master.hold, ticks=master.rate_drop, phase=phase)
        self.parts = make_parts(master)
        self.feedback = Feedback(master, phase=phase) if master.position.is_on else None
        self.heard = ("v", "x_s") if self.feedback else ("v",)
        equivalent = master.velocity_filter.kind == "equivalent"
        self._velocity = LessVelocity(master) if equivalent else None
        self.blocks: dict[str, Block] = {
            "": self.device,
            "filter.": self.filter,
            "hold.": self.hold,
        }
        for part in self.parts:
            self.blocks |= part.blocks
        if self._velocity:
            self.blocks["velocity_filter."] = self._velocity
        if self.feedback:
            self.blocks["position."] = self.feedback

    def send(self) -> list[Array]:
        """Return the packet of a frame start."""
        return [self.filter.sample()]

    def on_packet(self, packet: list[Array], since: int) -> None:
        """Take an answer, sent ``since`` ticks after the one before."""
        self.hold.load(packet[0])
        if self.feedback:
            self.feedback.on_packet(packet[1])

    def step(self, f_h: Array) -> tuple[Array, Array, Array]:
        """Go one tick on; return x, xd and the controller's force at its start."""
        x, xd = self.device.read()
        v = self.hold.step()
        if self.feedback:
            v = self.feedback.down(v, x)
        v, u = self._answered(v, xd)
        felt = self._velocity.step(xd) if self._velocity else xd
        force = self._b * felt - self._root * v
        for part in self.parts:
            u = part.step(u)
        self.filter.step(u)
        self.device.step(f_h - force)
        return x, xd, force

    def _answered(self, v: Array, xd: Array) -> tuple[Array, Array]:
        """Return v_m with the answers of the parts, and u_m, each depending on the other."""
        answer, gain = np.zeros((1, 1)), np.zeros((1, 1))
        for part in reversed(self.parts):
            v = part.down(v)
            own, slope = part.offer()
            answer, gain = answer + own, gain + slope
        u = (self._root * xd - v - answer) / (1.0 + gain)
        return v + answer + gain * u, u

    def wave(self, xd: Array) -> Array:
        """Return the wave, the same both ways, of a uniform motion without force."""
        return 0.5 * self._root * xd

    def steady(self, x: Array, xd: Array, x_s: Array) -> list[Array]:
        """Return the states in uniform motion while the avatar is heard to be at x_s."""
        u = self.wave(xd)
        found = [*self.device.steady(x, xd), *self.filter.steady(u), *self.hold.steady(u)]
        for part in self.parts:
            found += part.steady(u)
        found += self._velocity.steady(xd) if self._velocity else []
        return found + (self.feedback.steady(x_s) if self.feedback else [])


class DirectPort:
    """Direct coupling: motion goes up, force comes back and is held."""

    drifts: bool = True  # a uniform motion needs no force
    signals: tuple[str, ...] = ("x", "xd")
    heard: tuple[str, ...] = ("f",)
    feedback = None

    def __init__(self, user: User, *, tick_s: float, phase: int) -> None:
        self.device = Device(user.device, tick_s=tick_s)
        self.hold = Hold("zoh", ticks=user.master.rate_drop, phase=phase)
        self.blocks: dict[str, Block] = {"": self.device, "hold.": self.hold}

    def send(self) -> list[Array]:
        """Return the packet of a frame start."""
        return list(self.device.read())

    def on_packet(self, packet: list[Array], since: int) -> None:
        """Take an answer, sent ``since`` ticks after the one before."""
        self.hold.load(packet[0])

    def step(self, f_h: Array) -> tuple[Array, Array, Array]:
        """Go one tick on; return x, xd and the controller's force at its start."""
        x, xd = self.device.read()
        force = self.hold.step()
        self.device.step(f_h - force)
        return x, xd, force

    def wave(self, xd: Array) -> Array:
        """Return zero: nothing comes back in a motion without force."""
        return 0.0 * xd

    def steady(self, x: Array, xd: Array, x_s: Array) -> list[Array]:
        """Return the states in uniform motion."""
        return [*self.device.steady(x, xd), *self.hold.steady(0.0 * xd)]


class SpringPort:
    """Virtual coupling: motion goes up, the avatar's position comes back; spring and damper."""

    drifts: bool = False  # a uniform motion needs no force
    signals: tuple[str, ...] = ("x", "xd")
    heard: tuple[str, ...] = ("x_s",)
    feedback = None

    def __init__(self, user: User, *, tick_s: float, phase: int) -> None:
        coupling = user.baseline.virtual_coupling
        self._stiffness, self._damping = column(coupling.stiffness), column(coupling.damping)
        self._tick_s = tick_s
        self.device = Device(user.device, tick_s=tick_s)
        self._avatar = Kept(("p", "pd"))
        self.blocks: dict[str, Block] = {"": self.device, "avatar.": self._avatar}

    def send(self) -> list[Array]:
        """Return the packet of a frame start."""
        return list(self.device.read())

    def on_packet(self, packet: list[Array], since: int) -> None:
        """Take an answer; the avatar's velocity is that between the last two."""
        before, pd = self._avatar.state
        if since:
            pd = (packet[0] - before) / (since * self._tick_s)
        self._avatar.state = [packet[0], pd]

    def step(self, f_h: Array) -> tuple[Array, Array, Array]:
        """Go one tick on; return x, xd and the controller's force at its start."""
        (x, xd), (p, pd) = self.device.read(), self._avatar.state
        force = self._stiffness * (x - p) + self._damping * (xd - pd)
        self.device.step(f_h - force)
        return x, xd, force

    def wave(self, xd: Array) -> Array:
        """Return zero: there are none."""
        return 0.0 * xd

    def steady(self, x: Array, xd: Array, x_s: Array) -> list[Array]:
        """Return the states at rest; no uniform motion is without force."""
        return [*self.device.steady(x, xd), x_s, 0.0 * x_s]


Port = WavePort | DirectPort | SpringPort
PORTS: Mapping[str, type[Port]] = {
    "pmwvc": WavePort,
    "direct": DirectPort,
    "virtual_coupling": SpringPort,
}
