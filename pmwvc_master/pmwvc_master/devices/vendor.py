# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What devices of vendors have in common: a profile, one master each, a thread, a C library."""

import math
import os
import socket
import time
from collections.abc import Mapping, Sequence
from ctypes import CDLL
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pmwvc_core.errors import DeviceError
from pmwvc_core.frame import STALE_NS
from pmwvc_core.numeric import AXES, Value, flatten
from pmwvc_core.runtime.parameters import declare
from pmwvc_master.devices import DeviceInfo, DeviceSample, DeviceSetup, HapticDevice
from pmwvc_master.devices.profile import ORIGIN, Vector3, models_of, profile_of
from pmwvc_master.devices.turn import Turn

OPEN_S = 3.0
USB, NODES = Path("/sys/bus/usb/devices"), Path("/dev/bus/usb")


class Measurement(NamedTuple):
    """What a device measured, in its axes [m], [m/s]; how it is turned (:class:`.Turn`)."""

    at_ns: int
    x: Vector3
    xd: Vector3
    turned: Sequence[float] = ()
    buttons: int = 0


class VendorDevice(HapticDevice):
    """The part of a device that is alike for all; the force of its hand is not known."""

    axes, buttons = "x y z", 0

    def __init__(self, name: str, setup: DeviceSetup, kind: Any, params: Any) -> None:
        """Make a device from ``params``; else those that the node was given, or the defaults."""
        node = self._node = setup.node
        self._params = p = params or (kind() if node is None else declare(node, name, kind))
        self._name, self._tick_s = name, setup.tick_s
        known = self._profile = profile_of(name, p.model)
        self._claim: socket.socket | None = None
        self._turn = Turn(setup.lever_m) if known.turns and setup.dof == AXES else None
        zero = self._zero = np.zeros(3 if self._turn is None else AXES)
        self._driven = 3 if known.max_torque_n_m is None else len(zero)  # axes
        self.info = DeviceInfo(
            p.model, len(zero), known.max_force_n, known.continuous_force_n,
            known.apparent_mass_kg, None, known.workspace_m, known.encoder_step_m, "estimated",
            axes=self.axes, buttons=self.buttons, max_torque=known.max_torque_n_m or 0.0,
        )  # fmt: skip
        self._sample = DeviceSample(zero, zero, zero, valid=False)

    def _take(self, kind: Any, serial: str, asked: str = "", text: str = "") -> None:
        """Take a device for this process; DeviceError where it is another one than the one asked
        for, of another model, or another process has it.
        """
        text, model = f"the device is {text or kind}, serial number {serial}", self._params.model
        if asked not in ("", serial):
            raise DeviceError(f"{self._name}.serial = {asked}: {text}")
        types = [str(each) for each in self._profile.types]
        if types and not str(kind).startswith(tuple(types)):
            models = f"set its model: one of {', '.join(models_of(self._name))}, or a file"
            raise DeviceError(f"{self._name}.model = {model!r}: {text}; {models}")
        if self._claim is not None:
            return
        self._claim = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        try:
            self._claim.bind(f"\0pmwvc.{self._name}.{serial}")
        except OSError:
            self._give_back()
            why = "another master has it (their forces would add); name another one"
            raise DeviceError(f"{self._name}: device {serial}: {why}") from None
        text += "; no torque: a hand gives turns, and feels none" * (self._driven < self.info.dof)
        self._tell(f"{text}; profile: {'; '.join(self._profile.lines())}")

    def _give_back(self) -> None:
        if self._claim is not None:
            self._claim.close()
        self._claim = None

    def _tell(self, text: str) -> None:
        """Write a line to the log of the node, where there is one."""
        if self._node is not None:
            self._node.get_logger().info(f"{self.info.model}: {text}")

    def _sense(self, new: Measurement, centre_m: Vector3 = ORIGIN) -> None:
        """Take a motion over; it is invalid where it is none of finite numbers."""
        turn, sample, numbers = self._turn, self._sample, (*new.x, *new.xd, *new.turned)
        sample.valid, sample.buttons = all(map(math.isfinite, numbers)), new.buttons
        sample.valid = sample.valid and (turn is None or turn.add(new.turned, new.at_ns))
        if sample.valid:
            sample.x, sample.xd = np.subtract(new.x, centre_m), np.array(new.xd)
        if sample.valid and turn is not None:
            sample.x, sample.xd = np.append(sample.x, turn.way), np.append(sample.xd, turn.rate)
            sample.orientation = turn.orientation

    def stop(self) -> None:
        """Set the force to zero."""
        self.write(self._zero)


class ThreadedDevice(VendorDevice):
    """A device that a thread serves; measurement and force are each replaced as a whole."""

    _newest: Measurement | None = None
    _asked: tuple[int, Vector3] = (0, ORIGIN)  # when [ns], force on the hand [N]

    def _force(self, now_ns: int) -> Vector3:
        """Return the force to apply now; none that is older than ``STALE_NS``."""
        at_ns, force = self._asked
        return force if now_ns - at_ns <= STALE_NS else ORIGIN

    def _await_first(self) -> None:
        """Wait for the first measurement; DeviceError where none comes, or a wrong one."""
        until = time.monotonic() + OPEN_S
        while self._newest is None and time.monotonic() < until:
            time.sleep(0.001)
        if not self.read(time.monotonic_ns()).fresh:
            raise DeviceError(f"{self._name}: no measurement in {OPEN_S:g} s; see the device")

    def read(self, due_ns: int) -> DeviceSample:
        """Return the newest measurement of the thread; an old one is invalid."""
        sample, newest = self._sample, self._newest
        sample.fresh = newest is not None and newest.at_ns != sample.measured_ns
        if newest is not None and sample.fresh:
            self._sense(newest, self._profile.centre_m)
            sample.measured_ns = newest.at_ns
        elif sample.measured_ns is not None:
            sample.valid &= due_ns - sample.measured_ns <= STALE_NS
        return sample

    def write(self, f_m: Value) -> None:
        """Push the hand from the thread's next turn on, until the next call here."""
        self._asked = time.monotonic_ns(), (-flatten(f_m)[:3]).tolist()


class Library(NamedTuple):
    """A vendor's C library: its files, calls (types of result and arguments), and USB devices."""

    device: str
    names: Sequence[str]
    signatures: Mapping[str, Any]
    sdk: str
    usb: str  # the vendor's number

    def calls(self, path: str = "") -> dict[str, Any]:
        """Return the calls of the library at ``path``, else of the first name that the system
        finds; DeviceError where it, or one of them, is not there.
        """
        where, problem = f"{self.device}.library = {path!r}", ""
        for name in (path,) if path else self.names:
            try:
                library = CDLL(name)
                break
            except OSError as error:
                problem = problem or str(error)
        else:
            raise DeviceError(f"{where}: {problem}; install the {self.sdk} and name the file")
        if lacks := [name for name in self.signatures if not hasattr(library, name)]:
            raise DeviceError(f"{where}: lacks {', '.join(lacks)}; install a newer {self.sdk}")
        calls = {name: getattr(library, name) for name in self.signatures}
        for name, call in calls.items():
            call.restype, call.argtypes = self.signatures[name]
        return calls

    def look(self) -> str:
        """Return what there is; DeviceError without library, device or permission."""
        self.calls()
        return f"library there; {plugged_in(self.usb)}"


def plugged_in(vendor: str) -> str:
    """Return how many USB devices a vendor has here; DeviceError for none, or no permission."""
    folders = [each.parent for each in USB.glob("*/idVendor") if vendor in each.read_text()]
    if not folders:
        raise DeviceError(f"no USB device of the vendor {vendor}: plug it in and switch it on")
    for each in folders:
        bus, number = (int((each / name).read_text()) for name in ("busnum", "devnum"))
        path = NODES / f"{bus:03}/{number:03}"
        if not os.access(path, os.R_OK | os.W_OK):
            rule = f'SUBSYSTEM=="usb", ATTR{{idVendor}}=="{vendor}", MODE="0666"'
            text = f"a file /etc/udev/rules.d/90-haptic.rules with the line {rule}"
            raise DeviceError(f"{path} may not be opened: make {text}, and plug it in again")
    return f"{len(folders)} plugged in"
