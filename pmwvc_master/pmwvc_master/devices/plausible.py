# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Whether what a device says can be: metres, and velocities that fit the positions.

In blocks of ``BLOCK_NS``, so that counts of an encoder do not matter, the position moves by D and
the velocities sum up to V; over a second, unless at rest::

    ratio = sum(V . D) / sum(D . D)        1 where both are the same motion
"""

import math
import time
from collections import deque
from collections.abc import Callable
from dataclasses import replace

from pmwvc_core.errors import DeviceError
from pmwvc_core.frame import STALE_NS, DeviceSample
from pmwvc_core.numeric import Value, dot, flatten
from pmwvc_master.devices import HapticDevice

REACH = 1.01  # of the workspace: a stop gives way a little
FAR, FARTHEST_M = 3.0, 1.0  # times the workspace; where it is not known
BLOCK_NS, SECOND_NS = 20_000_000, 1_000_000_000
MOVED_M2 = 50 * 0.0003**2  # sum of D . D of a second in which something moved
OFF, SPAN = 1.9, 5  # ratio from which, or its inverse, velocities are estimated; of samples


class Slope:
    """Velocities compared with the slope of positions."""

    _last_ns = _begun_ns = _block_ns = -SECOND_NS
    _vd = _dd = 0.0
    _x: Value = 0.0
    _moved: Value = 0.0

    def add(self, now_ns: int, x: Value, xd: Value) -> float | None:
        """Take a new sample; return the ratio at the end of a second with motion."""
        last_ns, self._last_ns = self._last_ns, now_ns
        if 0 < now_ns - last_ns <= STALE_NS:
            self._moved = self._moved + xd * ((now_ns - last_ns) * 1e-9)
            if now_ns - self._block_ns < BLOCK_NS:
                return None
            by = x - self._x
            self._vd += float(flatten(dot(self._moved, by))[0])
            self._dd += float(flatten(dot(by, by))[0])
        self._block_ns, self._x, self._moved = now_ns, x, 0.0 * xd
        if now_ns - self._begun_ns < SECOND_NS:
            return None
        ratio = self._vd / self._dd if self._dd > MOVED_M2 else None
        self._begun_ns, self._vd, self._dd = now_ns, 0.0, 0.0
        return ratio


class Plausible:
    """A device of which only what can be is believed; ``tell`` takes what a user should know."""

    def __init__(self, device: HapticDevice, tell: Callable[[str], object]) -> None:
        self._device, self.info, self._tell = device, device.info, tell
        self.write, self.couple = device.write, device.couple
        self.stop, self.close = device.stop, device.close
        self._slope, self._wrong, self._far, self.ratio = Slope(), False, "", 0.0
        self._seen: deque[tuple[int, Value]] = deque(maxlen=SPAN)
        workspace_m = device.info.workspace_m
        self._most_m = FARTHEST_M if workspace_m is None else FAR * workspace_m
        self._reach_m = math.inf if workspace_m is None else REACH * workspace_m

    def open(self) -> None:
        """Open the device; DeviceError where its position cannot be one in metres."""
        try:
            self._device.open()
            self.read(time.monotonic_ns())
            if self._far:
                raise DeviceError(self._far)
        except DeviceError:
            self.close()
            raise

    def read(self, due_ns: int) -> DeviceSample:
        """Return the sample, invalid beyond any workspace, its velocity estimated if need be."""
        sample = self._device.read(due_ns)
        if not sample.valid:
            return sample
        at_m = flatten(sample.x)[:3]
        if (abs(at_m) > self._most_m).any():
            if not self._far:
                at = ", ".join(f"{each:.4g}" for each in at_m)
                most = f"at most {self._most_m:.4g} m can be: are these mm?"
                self._far = f"{self.info.model}: position ({at}) m from the middle, {most}"
                self._tell(self._far)
            return replace(sample, valid=False)  # the object is the device's
        if (abs(at_m) > self._reach_m).any():
            sample = replace(sample, outside=True)
        if sample.fresh:
            now_ns = due_ns if sample.measured_ns is None else sample.measured_ns
            ratio = self._slope.add(now_ns, sample.x, sample.xd)
            self.ratio = self.ratio if ratio is None else ratio
            if ratio is not None and not self._wrong and not 1.0 / OFF < ratio < OFF:
                self._wrong = True
                text = f"velocities are {ratio:.3g} times the slope of positions: that one is used"
                self._tell(f"{self.info.model}: {text}")
            self._seen.append((now_ns, sample.x))
        if self._wrong:
            (then_ns, x), (now_ns, newest) = self._seen[0], self._seen[-1]
            sample = replace(sample, xd=(newest - x) / (max(now_ns - then_ns, 1) * 1e-9))
        return sample
