# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Touch, Touch X and Phantom Omni by the vendor's library, ``libHD`` of OpenHaptics.

A thread of the library calls back a thousand times a second, reads position and velocity
(millimetres; x right, y up, z towards the user) and sets the force: a sample is up to a tick old.
With an error (motors too warm, a force or speed too large, no connection) there is none.
"""

import ctypes
import time
from ctypes import c_char_p, c_double, c_int, c_uint, c_ulong, c_ushort, c_void_p
from dataclasses import dataclass

from pmwvc_core.errors import DeviceError
from pmwvc_core.params.fields import Validated, fixed
from pmwvc_master.devices import DeviceSetup
from pmwvc_master.devices.vendor import Library, Measurement, ThreadedDevice

MM, NONE, PRIORITY, CONTINUE = 1e-3, 0xFFFFFFFF, 0x7FFF, 1
BUTTONS, POSITION, VELOCITY, FORCE, FORCE_OUTPUT = 0x2000, 0x2050, 0x2051, 0x2700, 0x4000
MODEL, SERIAL, CALIBRATION_STYLE, MAX_FORCE, TRANSFORM = 0x2501, 0x2504, 0x2555, 0x2603, 0x2052
CALIBRATED, NEEDS_UPDATE, MOST_ERRORS = 0x5000, 0x5001, 10  # taken off their stack in a turn
_CALLBACK, _THREE = ctypes.CFUNCTYPE(c_uint, c_void_p), c_double * 3


class _Error(ctypes.Structure):
    _fields_ = (("code", c_uint), ("internal", c_int), ("device", c_uint))


_DEVICE, _HANDLE, _NUMBERS = (c_uint,), (c_ulong,), (c_uint, ctypes.POINTER(c_double))
_CALLS = {
    "hdInitDevice": (c_uint, (c_char_p,)), "hdDisableDevice": (None, _DEVICE),
    "hdMakeCurrentDevice": (None, _DEVICE), "hdGetString": (c_char_p, _DEVICE),
    "hdGetError": (_Error, ()), "hdGetErrorString": (c_char_p, _DEVICE),
    "hdEnable": (None, _DEVICE), "hdDisable": (None, _DEVICE), "hdCheckCalibration": (c_uint, ()),
    "hdUpdateCalibration": (None, _DEVICE), "hdBeginFrame": (None, _DEVICE),
    "hdEndFrame": (None, _DEVICE), "hdGetIntegerv": (None, (c_uint, ctypes.POINTER(c_int))),
    "hdGetDoublev": (None, _NUMBERS), "hdSetDoublev": (None, _NUMBERS),
    "hdScheduleAsynchronous": (c_ulong, (_CALLBACK, c_void_p, c_ushort)),
    "hdStartScheduler": (None, ()), "hdStopScheduler": (None, ()), "hdUnschedule": (None, _HANDLE),
}  # fmt: skip
LIBRARY = Library("touch", ("libHD.so", "libHD.so.3.4"), _CALLS, "OpenHaptics SDK", "2988")


@dataclass(frozen=True)
class TouchParams(Validated):
    """Parameters of the node besides those of every device."""

    model: str = fixed("touch", "-", "model whose profile applies, or a YAML file with one")
    device: str = fixed("", "-", "name given in the vendor's setup (empty: its default device)")
    serial: str = fixed("", "-", "serial number that it must have (empty: any)")
    library: str = fixed("", "-", "path of libHD (empty: where the system finds it)")


class TouchDevice(ThreadedDevice):
    """One device at the library."""

    axes, buttons, look = "x -z y", 2, LIBRARY.look

    def __init__(self, setup: DeviceSetup, params: TouchParams | None = None) -> None:
        super().__init__("touch", setup, TouchParams, params)
        self._hd, self._callback = {}, _CALLBACK(self._frame)  # type: ignore[var-annotated]
        self._x, self._xd, self._id, self._scheduled = _THREE(), _THREE(), NONE, 0
        self._pen = (c_double * 16)()  # its axes, then its position, each in four numbers

    def open(self) -> None:
        """Load the library, open the device, start its thread with forces at zero."""
        name = self._params.device
        self._hd = hd = LIBRARY.calls(self._params.library)
        self._id = hd["hdInitDevice"](name.encode() or None)
        if (problem := self._error()) or self._id == NONE:
            ways = "plug it in, name it in the vendor's setup, end other programs that use it"
            raise DeviceError(f"touch.device = {name!r}: cannot be opened ({problem}): {ways}")
        hd["hdMakeCurrentDevice"](self._id)
        self._check()
        hd["hdEnable"](FORCE_OUTPUT)
        self._scheduled = hd["hdScheduleAsynchronous"](self._callback, None, PRIORITY)
        hd["hdStartScheduler"]()
        self._await_first()

    def _check(self) -> None:
        """Refuse another device or model, and one that is not calibrated."""
        model, serial = (str(self._hd["hdGetString"](n).decode()) for n in (MODEL, SERIAL))
        self._take(model, serial, self._params.serial)
        most, limit = c_double(), self._profile.max_force_n
        self._hd["hdGetDoublev"](MAX_FORCE, most)
        if limit is not None and limit > most.value:
            text = f"{self._params.model!r}: the library gives {most.value:g} N for a {model}"
            raise DeviceError(f"touch.model = {text}; set its model")
        if self._hd["hdCheckCalibration"]() == NEEDS_UPDATE:
            self._hd["hdGetIntegerv"](CALIBRATION_STYLE, style := c_int())
            self._hd["hdUpdateCalibration"](style.value)
        if self._hd["hdCheckCalibration"]() != CALIBRATED:
            raise DeviceError(f"touch: {model} is not calibrated; put the pen into its rest")

    def _error(self) -> str:
        code = self._hd["hdGetError"]().code
        return f"{code:#06x} {self._hd['hdGetErrorString'](code)!r}" if code else ""

    def _frame(self, _: int | None) -> int:
        """Exchange motion and force, in the library's thread."""
        hd, now_ns = self._hd, time.monotonic_ns()
        hd["hdBeginFrame"](self._id)
        hd["hdGetDoublev"](POSITION, self._x)
        hd["hdGetDoublev"](VELOCITY, self._xd)
        if self._turn is not None:
            hd["hdGetDoublev"](TRANSFORM, self._pen)
        hd["hdGetIntegerv"](BUTTONS, buttons := c_int())
        hd["hdSetDoublev"](FORCE, _THREE(*self._force(now_ns)))
        hd["hdEndFrame"](self._id)
        if not [*zip(range(MOST_ERRORS), iter(lambda: hd["hdGetError"]().code, 0), strict=False)]:
            x, xd = ([MM * each for each in vector] for vector in (self._x, self._xd))
            rows = [self._pen[4 * axis + row] for row in range(3) for axis in range(3)]
            self._newest = Measurement(now_ns, x, xd, rows, buttons.value)
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
