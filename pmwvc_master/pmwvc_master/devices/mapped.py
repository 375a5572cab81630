# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Between a driver and the force loop: axes, middle and scale of a device, and its clutch.

The device moves by dd, the avatar is told dx; the device renders f_d where the loop asks for f::

    dx = c S dd,   f_d = c S^T f:   f_d . dd = f . dx,   whatever c and S are

S has one entry s or -s a row, 1 or -1 for turns: ``device.axes`` and ``device.scale``. c is 1, and
0 while the hand is uncoupled; it changes over ``FADE_S`` or longer, so that f_d changes by at most
its slew. Where c < 1 the position is the sum of dx: the avatar stands where it was left.
"""

import math
from dataclasses import replace

import numpy as np

from pmwvc_core.ends.inbox import value
from pmwvc_core.errors import DeviceError
from pmwvc_core.law.safety.limits import FADE_S
from pmwvc_core.numeric import Array, Value, finite, flatten
from pmwvc_core.params import DeviceParams
from pmwvc_master.devices import PLUGINS, DeviceInfo, DeviceSample, DeviceSetup, HapticDevice
from pmwvc_master.devices.plausible import Plausible


def make_device(name: str, setup: DeviceSetup) -> "Mapped":
    """Make the device of a plug-in; it is not opened yet. DeviceError where there is no such
    plug-in (naming those there are), or what it makes is no device with that many axes.
    """
    device: HapticDevice = PLUGINS.make(name, setup)
    if device.info.dof < setup.dof:
        text = f"has {device.info.dof} axes; set dof = {setup.dof} to {device.info.dof} or less"
        raise DeviceError(f"device.plugin = {name!r}: {text}")
    tell = print if setup.node is None else setup.node.get_logger().warning
    return Mapped(device if setup.device.is_simulated else Plausible(device, tell), setup)


class Mapped:
    """A device as the loop has it; ``pressed`` uncouples the hand, as its button does."""

    def __init__(self, device: HapticDevice, setup: DeviceSetup) -> None:
        given, info = setup.device, device.info
        self._device, self.info = device, replace(info, dof=setup.dof)
        self.open, self.couple, self.close = device.open, device.couple, device.close
        self._matrix = matrix_of(info, given)[: setup.dof]
        self._of_hand = np.linalg.pinv(self._matrix).T  # f_h . dd = (that times f_h) . dx
        if given.clutch > info.buttons:
            text = f"{info.model} has {info.buttons} buttons; call ~/clutch instead"
            raise DeviceError(f"device.clutch = {given.clutch}: {text}")
        self._button, self.pressed = 1 << given.clutch >> 1, False
        self.slew_n, self._step = setup.max_slew_n_s * setup.tick_s, setup.tick_s / FADE_S
        offset = np.array([given.offset_x_m, given.offset_y_m, given.offset_z_m, 0.0, 0.0, 0.0])
        self._shift = self._x = offset[: setup.dof] * (not given.is_simulated)
        self._at, self._f = 0.0 * self._x, np.zeros(info.dof)
        self._c, self._uncoupled, self._went = 1.0, False, False
        self.uncoupled = False  # whether the avatar does not follow the hand
        self._sample = DeviceSample(value(self._x), value(self._at), value(self._at))

    @property
    def ratio(self) -> float:
        """Velocities over the slope of positions; zero: too little motion, or a simulated one."""
        return self._device.ratio if isinstance(self._device, Plausible) else 0.0

    def read(self, due_ns: int) -> DeviceSample:
        """Return motion and force of the hand as the avatar has them."""
        there, own, c = self._device.read(due_ns), self._sample, self._c
        self._uncoupled = self.pressed or bool(there.buttons & self._button)
        own.valid, own.fresh, own.outside = there.valid, there.fresh, there.outside
        own.work, own.measured_ns = there.work, there.measured_ns
        if not there.valid:
            return own
        at = self._matrix @ flatten(there.x)
        x = at + self._shift
        if finite(at):  # what is no number is so for this tick only
            if c < 1.0:
                x = self._x + c * (at - self._at)
                self._shift = x - at
            self._x, self._at = x, at
        own.x, own.xd = value(x), value(c * (self._matrix @ flatten(there.xd)))
        self._went = self._went or c < 1.0  # from then on the orientation follows the way
        q = () if self._went else there.orientation
        own.orientation = (*(self._matrix[3:, 3:] @ q[:3]).tolist(), q[3]) if q else ()
        own.f_h = value(c * (self._of_hand @ (flatten(there.f_h) + 0.0 * self._f)))
        return own

    def write(self, f_m: Value) -> None:
        """Push the hand with its part of the force."""
        f = flatten(f_m) @ self._matrix
        self._c = self._coupling(f)
        self.uncoupled = self._c < 1.0
        self._f = self._c * f
        self._device.write(value(self._f))

    def _coupling(self, f: Array) -> float:
        """Return c for a tick whose whole force is f: |c f - f before| is at most the slew."""
        before, ff = self._c, float(f @ f)
        wanted = 0.0 if self._uncoupled else 1.0
        wanted = min(max(wanted, before - self._step), before + self._step)
        if wanted == before or ff == 0.0:
            return wanted
        middle = float(f @ self._f) / ff
        square = middle * middle - (float(self._f @ self._f) - self.slew_n**2) / ff
        way = math.sqrt(max(square, 0.0))
        return min(max(wanted, middle - way, 0.0), middle + way, 1.0)

    def stop(self) -> None:
        """Set the force to zero."""
        self._f = 0.0 * self._f
        self._device.stop()


def matrix_of(info: DeviceInfo, given: DeviceParams) -> Array:
    """Return the matrix from motion of a device to that of its avatar; DeviceError for axes that
    the device has not.
    """
    names = "xyz"[: info.dof]
    words = ((not given.is_simulated and given.axes) or info.axes or " ".join(names)).split()
    if sorted(word[-1] for word in words) != list(names):
        needs = f"{info.model} has {' '.join(names)}; each must be there once"
        raise DeviceError(f"device.axes = {given.axes!r}: {needs}, like 'y -x z'")
    turned = np.array(
        [[(-1.0) ** (word[0] == "-") * (word[-1] == n) for n in names] for word in words]
    )
    matrix = np.eye(info.dof)
    matrix[:3, :3] = given.scale * turned
    if info.dof > len(turned):  # a turn is mirrored where the axes are
        matrix[3:, 3:] = np.round(np.linalg.det(turned)) * turned
    return matrix
