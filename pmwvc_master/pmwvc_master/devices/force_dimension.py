# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Omega, Delta, Sigma and Falcon by the vendor's library, ``libdhd`` of the Force Dimension SDK.

Axes: x towards the user, y right, z up. The library forms velocities from positions, by default
over 20 ms, which would make them 10 ms late; here over one tick. A negative result is an error:
such a read, or the one after a force that was refused, is invalid; 1: nothing new.
"""

from ctypes import POINTER, byref, c_byte, c_char_p, c_double, c_int, c_ubyte, c_uint, c_ushort
from dataclasses import dataclass
from typing import Any

from pmwvc_core.errors import DeviceError
from pmwvc_core.numeric import Value, flatten
from pmwvc_core.params.fields import Validated, fixed
from pmwvc_master.devices import DeviceSample, DeviceSetup
from pmwvc_master.devices.vendor import Library, Measurement, VendorDevice

NOTHING_NEW, STATUS_SIZE = 1, 64  # DHD_TIMEGUARD; 16 in SDK 3.7, perhaps more later
# Of the status, which must not be 0: DHD_STATUS_POWER and DHD_STATUS_RESET.
READY = {0: "switch it on", 3: "calibrate it by HapticInit of the SDK"}
_VECTOR = (*(POINTER(c_double),) * 3, c_byte)
_CALLS = {
    "dhdOpen": (c_int, ()), "dhdOpenSerial": (c_int, (c_int,)), "dhdClose": (c_int, (c_byte,)),
    "dhdErrorGetLastStr": (c_char_p, ()), "dhdGetSystemName": (c_char_p, (c_byte,)),
    "dhdGetSystemType": (c_int, (c_byte,)), "dhdEnableForce": (c_int, (c_ubyte, c_byte)),
    "dhdGetSerialNumber": (c_int, (POINTER(c_ushort), c_byte)),
    "dhdConfigLinearVelocity": (c_int, (c_int, c_int, c_byte)),
    "dhdGetStatus": (c_int, (POINTER(c_int), c_byte)), "dhdGetPosition": (c_int, _VECTOR),
    "dhdGetButtonMask": (c_uint, (c_byte,)),
    "dhdGetOrientationFrame": (c_int, (POINTER(c_double), c_byte)),
    "dhdSetForceAndTorque": (c_int, (*(c_double,) * 6, c_byte)),
    "dhdGetLinearVelocity": (c_int, _VECTOR), "dhdSetForce": (c_int, (*(c_double,) * 3, c_byte)),
}  # fmt: skip
SDK = "Force Dimension SDK (3.7 or later)"
LIBRARY = Library("force_dimension", ("libdhd.so.3", "libdhd.so"), _CALLS, SDK, "1451")


@dataclass(frozen=True)
class ForceDimensionParams(Validated):
    """Parameters of the node besides those of every device."""

    model: str = fixed("omega.3", "-", "model whose profile applies, or a YAML file with one")
    serial: int = fixed(0, ">= 0", "serial number (0: the first that is free)")
    library: str = fixed("", "-", "path of libdhd (empty: where the system finds it)")


class ForceDimensionDevice(VendorDevice):
    """One device at the library."""

    axes, buttons, look = "y -x z", 32, LIBRARY.look

    def __init__(self, setup: DeviceSetup, params: ForceDimensionParams | None = None) -> None:
        super().__init__("force_dimension", setup, ForceDimensionParams, params)
        self._x, self._xd = [c_double() for _ in "xyz"], [c_double() for _ in "xyz"]
        self._dhd: dict[str, Any] = {}
        self._frame, self._lever_m = (c_double * 9)(), setup.lever_m  # of the handle, by rows
        self._id, self._refused = -1, False  # of an open device; the last force

    def open(self) -> None:
        """Load the library, open the device, switch its forces on, at zero."""
        self._dhd, serial = LIBRARY.calls(self._params.library), self._params.serial
        self._id = self._dhd["dhdOpenSerial"](serial) if serial else self._dhd["dhdOpen"]()
        if self._id < 0:
            text = f"no {f'serial = {serial}' if serial else 'device'} can be opened"
            ways = "plug it in, switch it on, end other programs on it; see pmwvc devices"
            raise DeviceError(f"force_dimension: {text} ({self._error()}): {ways}")
        self._check()
        self._do("dhdConfigLinearVelocity", max(round(self._tick_s * 1e3), 1), 0)
        self._do("dhdSetForce", 0.0, 0.0, 0.0)
        self._do("dhdEnableForce", 1)

    def _check(self) -> None:
        """Refuse another model, and a device without power or calibration."""
        kind, name = (self._dhd[f"dhdGetSystem{each}"](self._id) for each in ("Type", "Name"))
        serial, asked = c_ushort(), self._params.serial
        self._do("dhdGetSerialNumber", byref(serial))
        text = f"{(name or b'').decode()} (type {kind})"
        self._take(kind, str(serial.value), str(asked or ""), text)
        status = (c_int * STATUS_SIZE)()
        self._do("dhdGetStatus", status)
        for at, remedy in READY.items():
            if not status[at]:
                raise DeviceError(f"force_dimension: {text} is not ready; {remedy}")

    def _do(self, name: str, *arguments: Any) -> None:
        if self._dhd[name](*arguments, self._id) < 0:
            raise DeviceError(f"force_dimension: {name} failed: {self._error()}")

    def _error(self) -> str:
        return str((self._dhd["dhdErrorGetLastStr"]() or b"unknown error").decode())

    def read(self, due_ns: int) -> DeviceSample:
        """Return position and velocity."""
        there = self._dhd["dhdGetPosition"](*self._x, self._id)
        moves = self._dhd["dhdGetLinearVelocity"](*self._xd, self._id)
        turns = self._dhd["dhdGetOrientationFrame"](self._frame, self._id) if self._turn else 0
        self._sample.fresh, buttons = there != NOTHING_NEW, self._dhd["dhdGetButtonMask"](self._id)
        if known := min(there, moves, turns) >= 0:
            x, xd = ([each.value for each in vector] for vector in (self._x, self._xd))
            self._sense(Measurement(due_ns, x, xd, list(self._frame), buttons))
        self._sample.valid &= known and not self._refused
        return self._sample

    def write(self, f_m: Value) -> None:
        """Push the hand until the next call."""
        if self._id >= 0:
            push = -flatten(f_m)[: self._driven]
            push[3:] *= self._lever_m
            name = "dhdSetForce" if self._driven == 3 else "dhdSetForceAndTorque"
            self._refused = self._dhd[name](*push, self._id) < 0

    def close(self) -> None:
        """Switch the forces off and give the device back."""
        if self._id >= 0:
            self._dhd["dhdEnableForce"](0, self._id)
            self._dhd["dhdClose"](self._id)
        self._id = -1
        self._give_back()
