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
import re
from dataclasses import replace

import numpy as np

from pmwvc_core.ends.inbox import value, vector
from pmwvc_core.errors import DeviceError
from pmwvc_core.law.safety.limits import FADE_S, LARGEST
from pmwvc_core.law.vectors import Vector, dot, minus, plus, scaled, within, zero
from pmwvc_core.numeric import Value
from pmwvc_core.params import DeviceParams
from pmwvc_master.devices import DeviceInfo, DeviceSample, DeviceSetup, HapticDevice


class Mapped:
    """A device as the loop has it; ``pressed`` uncouples the hand, as its button does."""

    def __init__(self, device: HapticDevice, setup: DeviceSetup) -> None:
        given = setup.device
        self._device, self.info = device, replace(device.info, dof=setup.dof)
        self.open, self.couple = device.open, device.couple
        self.close, self._dof = device.close, device.info.dof
        self._ways = ways_of(device.info, given)[: setup.dof]
        if given.clutch > device.info.buttons:
            text = f"{device.info.model} has {device.info.buttons} buttons; call ~/clutch instead"
            raise DeviceError(f"device.clutch = {given.clutch}: {text}")
        self._button, self.pressed = 1 << given.clutch >> 1, False
        self.slew_n, self._step = setup.max_slew_n_s * setup.tick_s, setup.tick_s / FADE_S
        offset = (*given.offset * (not given.is_simulated), *(0.0,) * setup.dof)[: setup.dof]
        self._shift, self._x, self._at = offset, offset, zero(offset)
        self._c, self._uncoupled, self._f = 1.0, False, zero(offset)
        self._sample = DeviceSample(value(offset), *(value(zero(offset)),) * 2)

    @property
    def uncoupled(self) -> bool:
        """Whether the avatar does not follow the hand."""
        return self._c < 1.0

    def read(self, due_ns: int) -> DeviceSample:
        """Return motion and force of the hand as the avatar has them."""
        there, own, c = self._device.read(due_ns), self._sample, self._c
        self._uncoupled = self.pressed or bool(there.buttons & self._button)
        own.valid, own.fresh, own.outside = there.valid, there.fresh, there.outside
        own.work, own.measured_ns = there.work, there.measured_ns
        if not there.valid:
            return own
        at, xd = self._turned(there.x), self._turned(there.xd)
        x = plus(at, self._shift)
        if within(at, LARGEST):  # what is no number is so for this tick only
            if c < 1.0:
                x = plus(self._x, scaled(minus(at, self._at), c))
                self._shift = minus(x, at)
            self._x, self._at = x, at
        f_h = vector(there.f_h, self._dof)
        own.x, own.xd = value(x), value(scaled(xd, c))
        own.f_h = value(tuple(c / factor * f_h[axis] for axis, factor in self._ways))
        return own

    def _turned(self, motion: Value) -> Vector:
        of_device = vector(motion, self._dof)
        return tuple(factor * of_device[axis] for axis, factor in self._ways)

    def write(self, f_m: Value) -> None:
        """Push the hand with its part of the force."""
        wanted = vector(f_m, len(self._ways))
        f = tuple(factor * each for (_, factor), each in zip(self._ways, wanted, strict=True))
        self._c = c = self._coupling(f)
        self._f, force = scaled(f, c), [0.0] * self._dof
        for (axis, _), each in zip(self._ways, self._f, strict=True):
            force[axis] = each
        self._device.write(value(tuple(force)))

    def _coupling(self, f: Vector) -> float:
        """Return c for a tick whose whole force is f: |c f - f before| is at most the slew."""
        before, ff = self._c, dot(f, f)
        wanted = 0.0 if self._uncoupled else 1.0
        wanted = min(max(wanted, before - self._step), before + self._step)
        if wanted == before or ff == 0.0:
            return wanted
        middle = dot(f, self._f) / ff
        square = middle * middle - (dot(self._f, self._f) - self.slew_n**2) / ff
        way = math.sqrt(max(square, 0.0))
        return min(max(wanted, middle - way, 0.0), middle + way, 1.0)

    def stop(self) -> None:
        """Set the force to zero."""
        self._f = zero(self._f)
        self._device.stop()


def ways_of(info: DeviceInfo, given: DeviceParams) -> list[tuple[int, float]]:
    """Return axis of the device and factor of its motion for each axis of the world; DeviceError
    for axes that the device has not.
    """
    names = "xyz"[: info.dof]
    text = info.axes if given.is_simulated else given.axes or info.axes
    found = re.findall(r"(-?)([xyz])", text or " ".join(names))
    if sorted(axis for _, axis in found) != list(names):
        needs = f"{info.model} has {' '.join(names)}; each must be there once"
        raise DeviceError(f"device.axes = {given.axes!r}: {needs}, like 'y -x z'")
    ways = [(names.index(axis), -1.0 if sign else 1.0) for sign, axis in found]
    turns = [(axis, 1.0) for axis in range(3, info.dof)]
    if info.dof == 2 * len(names):  # a turn is mirrored where the axes are
        mirrors = np.linalg.det([[sign * (axis == k) for k in range(3)] for axis, sign in ways])
        turns = [(axis + 3, sign * round(mirrors)) for axis, sign in ways]
    return [(axis, sign * given.scale) for axis, sign in ways] + turns
