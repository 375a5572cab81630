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

from pmwvc_core.ends.inbox import value, vector
from pmwvc_core.errors import DeviceError
from pmwvc_core.law.safety.limits import FADE_S
from pmwvc_core.law.vectors import Vector, dot, measured, minus, plus, scaled, squared, times, zero
from pmwvc_core.numeric import Value
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
        self.device, self.info = device, replace(info, dof=setup.dof)
        self.open, self.couple, self.stop = device.open, device.couple, device.stop
        self.close = device.close
        axes, factors = axes_of(info, given)
        self._axes, self._s = axes[: setup.dof], factors[: setup.dof]
        self._per_s: Vector = tuple(1.0 / s for s in self._s)  # f_h . dd = (f_h / S) . dx
        if given.clutch > info.buttons:
            text = f"{info.model} has {info.buttons} buttons; call ~/clutch instead"
            raise DeviceError(f"device.clutch = {given.clutch}: {text}")
        self._button, self.pressed = 1 << given.clutch >> 1, False
        self.slew_n, self._step = setup.max_slew_n_s * setup.tick_s, setup.tick_s / FADE_S
        offset = (given.offset_x_m, given.offset_y_m, given.offset_z_m, 0.0, 0.0, 0.0)
        self._shift = self._x = scaled(offset[: setup.dof], float(not given.is_simulated))
        self._at, self._f = zero(self._x), (0.0,) * info.dof
        self._c, self._uncoupled, self._went = 1.0, False, False
        self.uncoupled = False  # whether the avatar does not follow the hand
        self._sample = DeviceSample(value(self._x), value(self._at), value(self._at))

    def read(self, due_ns: int) -> DeviceSample:
        """Return motion and force of the hand as the avatar has them."""
        there, own, c = self.device.read(due_ns), self._sample, self._c
        self._uncoupled = self.pressed or bool(there.buttons & self._button)
        own.valid, own.fresh, own.outside = there.valid, there.fresh, there.outside
        own.work, own.measured_ns = there.work, there.measured_ns
        if not there.valid:
            return own
        at = self._of_device(there.x, self._s)
        x = plus(at, self._shift)
        if measured(at):  # what is no number is so for this tick only
            if c < 1.0:
                x = plus(self._x, scaled(minus(at, self._at), c))
                self._shift = minus(x, at)
            self._x, self._at = x, at
        own.x, own.xd = value(x), value(scaled(self._of_device(there.xd, self._s), c))
        self._went = self._went or c < 1.0  # from then on the orientation follows the way
        own.orientation, q = (), there.orientation
        if q and not self._went:
            turned = zip(self._axes[3:], self._s[3:], strict=True)
            own.orientation = (*(q[axis - 3] * factor for axis, factor in turned), q[3])
        own.f_h = value(scaled(self._of_device(there.f_h, self._per_s), c))
        return own

    def _of_device(self, signal: Value, factors: Vector) -> Vector:
        """Return a signal of the device along the axes of the avatar, times a factor each."""
        along = vector(signal, len(self._f))
        return times(tuple([along[axis] for axis in self._axes]), factors)

    def write(self, f_m: Value) -> None:
        """Push the hand with its part of the force."""
        wanted = times(vector(f_m, len(self._s)), self._s)
        along = dict(zip(self._axes, wanted, strict=True))
        f = tuple([along.get(axis, 0.0) for axis in range(len(self._f))])
        self._c = self._coupling(f)
        self.uncoupled = self._c < 1.0
        self._f = scaled(f, self._c)
        self.device.write(value(self._f))

    def _coupling(self, f: Vector) -> float:
        """Return c for a tick whose whole force is f: |c f - f before| is at most the slew."""
        before, ff = self._c, squared(f)
        wanted = 0.0 if self._uncoupled else 1.0
        wanted = min(max(wanted, before - self._step), before + self._step)
        if wanted == before or ff == 0.0:
            return wanted
        middle = dot(f, self._f) / ff
        square = middle * middle - (squared(self._f) - self.slew_n**2) / ff
        way = math.sqrt(max(square, 0.0))
        return min(max(wanted, middle - way, 0.0), middle + way, 1.0)


def axes_of(info: DeviceInfo, given: DeviceParams) -> tuple[tuple[int, ...], Vector]:
    """Return the axis of a device along each one of its avatar, and the entry of S; DeviceError
    for axes that the device has not.
    """
    names = "xyz"[: info.dof]
    words = ((not given.is_simulated and given.axes) or info.axes or " ".join(names)).split()
    if sorted(word[-1] for word in words) != list(names):
        needs = f"{info.model} has {' '.join(names)}; each must be there once"
        raise DeviceError(f"device.axes = {given.axes!r}: {needs}, like 'y -x z'")
    axes = tuple(names.index(word[-1]) for word in words)
    signs = tuple(-1.0 if word[0] == "-" else 1.0 for word in words)
    if info.dof <= len(words):
        return axes, scaled(signs, given.scale)
    mirror = float(np.linalg.det(np.diag(signs)[:, axes]).round())  # a turn is mirrored like axes
    turns = tuple(3 + axis for axis in axes)
    return axes + turns, scaled(signs, given.scale) + scaled(signs, mirror)
