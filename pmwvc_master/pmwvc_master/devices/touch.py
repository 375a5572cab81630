# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Touch, Touch X and Phantom Omni by the vendor's library, ``libHD`` of OpenHaptics.

A thread of the library calls back a thousand times a second. Each call reads position and velocity
(millimetres; x right, y up, z towards the user), sets the force, and leaves what it read in a
mailbox, from which the loop takes the newest: a sample is up to a tick old. An error of the
library (motors too warm, a force or speed too large, no connection) makes a sample invalid.
"""

import ctypes
import time
from ctypes import c_char_p, c_double, c_int, c_uint, c_ulong, c_ushort, c_void_p
from dataclasses import dataclass

from pmwvc_core.errors import DeviceError
from pmwvc_core.params.fields import fixed
from pmwvc_master.devices import DeviceSetup
from pmwvc_master.devices.listing import plugged_in
from pmwvc_master.devices.vendor import (
    Calls,
    Measurement,
    ThreadedDevice,
    VendorParams,
    library_calls,
)  # fmt: skip

VENDOR, SDK = "2988", "OpenHaptics SDK"
LIBRARIES = ("libHD.so", "libHD.so.3.4")
MM, NONE, PRIORITY, CONTINUE = 1e-3, 0xFFFFFFFF, 0x7FFF, 1
POSITION, VELOCITY, FORCE, FORCE_OUTPUT = 0x2050, 0x2051, 0x2700, 0x4000
MODEL, SERIAL, CALIBRATION_STYLE = 0x2501, 0x2504, 0x2555
MAX_FORCE, CALIBRATED, NEEDS_UPDATE = 0x2603, 0x5000, 0x5001
_CALLBACK = ctypes.CFUNCTYPE(c_uint, c_void_p)
_THREE = c_double * 3


class _Error(ctypes.Structure):
    _fields_ = (("code", c_uint), ("internal", c_int), ("device", c_uint))


_NUMBERS = (c_uint, ctypes.POINTER(c_double))
_CALLS = {
    "hdInitDevice": (c_uint, (c_char_p,)), "hdDisableDevice": (None, (c_uint,)),
    "hdMakeCurrentDevice": (None, (c_uint,)), "hdGetString": (c_char_p, (c_uint,)),
    "hdGetError": (_Error, ()), "hdGetErrorString": (c_char_p, (c_uint,)),
    "hdEnable": (None, (c_uint,)), "hdDisable": (None, (c_uint,)),
    "hdCheckCalibration": (c_uint, ()), "hdUpdateCalibration": (None, (c_uint,)),
    "hdBeginFrame": (None, (c_uint,)), "hdEndFrame": (None, (c_uint,)),
    "hdGetIntegerv": (None, (c_uint, ctypes.POINTER(c_int))),
    "hdGetDoublev": (None, _NUMBERS), "hdSetDoublev": (None, _NUMBERS),
    "hdScheduleAsynchronous": (c_ulong, (_CALLBACK, c_void_p, c_ushort)),
    "hdUnschedule": (None, (c_ulong,)),
    "hdStartScheduler": (None, ()), "hdStopScheduler": (None, ()),
}  # fmt: skip


@dataclass(frozen=True)
class TouchParams(VendorParams):
    """Parameters of the node besides those of every device."""

    model: str = fixed("touch", "-", "model whose profile applies, or a YAML file with one")
    device: str = fixed("", "-", "name given in the vendor's setup (empty: its default device)")
    serial: str = fixed("", "-", "serial number that it must have (empty: any)")
    library: str = fixed("", "-", "path of libHD (empty: where the system finds it)")
    axes: str = fixed("x -z y", "-", "axes of the device that are axes 0, 1, 2 of the world")


class TouchDevice(ThreadedDevice[TouchParams]):
    """One device at the library."""

    def __init__(self, setup: DeviceSetup, params: TouchParams | None = None) -> None:
        super().__init__("touch", setup, TouchParams, params)
        self._hd, self._callback = Calls(), _CALLBACK(self._frame)
        self._x, self._xd, self._id, self._scheduled = _THREE(), _THREE(), NONE, 0

    @staticmethod
    def look() -> str:
        """Return what there is; DeviceError without library, device or permission."""
        library_calls("touch", "", LIBRARIES, _CALLS, SDK)
        return f"library there; {plugged_in(VENDOR)}"

    def open(self) -> None:
        """Load the library, open the device, start its thread with forces at zero."""
        name = self._params.device
        self._hd = hd = library_calls("touch", self._params.library, LIBRARIES, _CALLS, SDK)
        self._id = hd["hdInitDevice"](name.encode() or None)
        try:
            if (problem := self._error()) or self._id == NONE:
                ways = "plug it in, name it in the vendor's setup, end other programs that use it"
                raise DeviceError(f"touch.device = {name!r}: cannot be opened ({problem}): {ways}")
            hd["hdMakeCurrentDevice"](self._id)
            self._check()
            hd["hdEnable"](FORCE_OUTPUT)
            self._scheduled = hd["hdScheduleAsynchronous"](self._callback, None, PRIORITY)
            hd["hdStartScheduler"]()
            if problem := self._error():
                raise DeviceError(f"touch: its thread cannot be started ({problem})")
            self._await_first()
        except DeviceError:
            self.close()
            raise

    def _check(self) -> None:
        """Refuse another device or model, and one that is not calibrated."""
        model, serial = (str(self._hd["hdGetString"](n).decode()) for n in (MODEL, SERIAL))
        self._take(model, serial, self._params.serial)
        most, limit = c_double(), self._profile.max_force_n
        self._hd["hdGetDoublev"](MAX_FORCE, most)
        if limit is not None and limit > most.value:
            text = f"the library gives {most.value:g} N for a {model}; set its model"
            raise DeviceError(f"touch.model = {self._params.model!r}: {text}")
        state = self._hd["hdCheckCalibration"]()
        if state == NEEDS_UPDATE:
            style = c_int()
            self._hd["hdGetIntegerv"](CALIBRATION_STYLE, style)
            self._hd["hdUpdateCalibration"](style.value)
            state = self._hd["hdCheckCalibration"]()
        if state != CALIBRATED:
            raise DeviceError(f"touch: {model} is not calibrated; put the pen into its rest")

    def _error(self) -> str:
        code = self._hd["hdGetError"]().code
        text = (self._hd["hdGetErrorString"](code) or b"").decode() if code else ""
        return text or (f"error {code:#06x}" if code else "")

    def _frame(self, _: int | None) -> int:
        """Exchange motion and force, in the library's thread."""
        hd, now_ns = self._hd, time.monotonic_ns()
        hd["hdBeginFrame"](self._id)
        hd["hdGetDoublev"](POSITION, self._x)
        hd["hdGetDoublev"](VELOCITY, self._xd)
        hd["hdSetDoublev"](FORCE, _THREE(*self._box.force(now_ns)))
        hd["hdEndFrame"](self._id)
        trusted = not hd["hdGetError"]().code
        x, xd = ([MM * each for each in vector] for vector in (self._x, self._xd))
        self._box.newest = Measurement(now_ns, x, xd, trusted)
        return CONTINUE

    def close(self) -> None:
        """Stop the thread, switch the forces off, give the device back."""
        if self._id != NONE:
            if self._scheduled:
                self._hd["hdStopScheduler"]()
                self._hd["hdUnschedule"](self._scheduled)
            self._hd["hdMakeCurrentDevice"](self._id)
            self._hd["hdDisable"](FORCE_OUTPUT)
            self._hd["hdDisableDevice"](self._id)
        self._id, self._scheduled = NONE, 0
        self._give_back()
