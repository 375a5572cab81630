# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What devices of vendors have in common: a profile, axes, parameters, one master each; calls of a
C library; and a mailbox, where a thread serves the device.
"""

import math
import re
import socket
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from ctypes import CDLL
from dataclasses import dataclass
from typing import Any, Generic, NamedTuple, TypeVar

from pmwvc_core.ends.inbox import value
from pmwvc_core.errors import DeviceError
from pmwvc_core.frame import STALE_NS
from pmwvc_core.numeric import Value, flatten
from pmwvc_core.params.fields import Validated
from pmwvc_core.runtime.parameters import declare
from pmwvc_master.devices import DeviceInfo, DeviceSample, DeviceSetup
from pmwvc_master.devices.plausible import beyond
from pmwvc_master.devices.profile import ORIGIN, Vector3, models_of, profile_of

MOST_AXES, OPEN_S = 3, 3.0


@dataclass(frozen=True)
class VendorParams(Validated):
    """What the parameters of each have: the model of its profile, and ``Axes``."""

    model: str = ""
    axes: str = ""


P = TypeVar("P", bound=VendorParams)
Calls = dict[str, Callable[..., Any]]


class Measurement(NamedTuple):
    """What a device measured, in its axes [m], [m/s]; ``trusted``: without an error."""

    at_ns: int
    x: Vector3
    xd: Vector3
    trusted: bool


class Mailbox:
    """Between a thread and the loop: the newest measurement, the newest force, each replaced as a
    whole. No force is older than ``STALE_NS``: a loop that stalls pushes nobody.
    """

    newest: Measurement | None = None
    _force: tuple[int, Vector3] = (0, ORIGIN)

    def ask(self, force: Vector3, now_ns: int) -> None:
        """Have a force on the hand applied from now on [N]."""
        self._force = now_ns, force

    def force(self, now_ns: int) -> Vector3:
        """Return the force to apply now [N]."""
        at_ns, force = self._force
        return force if now_ns - at_ns <= STALE_NS else ORIGIN


class Axes:
    """World axes by those of the device: ``y -x z`` makes its y the axis 0, its -x the axis 1.
    Axes of the device beyond ``dof`` move freely.
    """

    def __init__(self, parameter: str, text: str, setup: DeviceSetup) -> None:
        found = re.findall(r"(-?)([xyz])", text)
        if sorted(axis for _, axis in found) != ["x", "y", "z"] or len(text.split()) != 3:
            raise DeviceError(f"{parameter} = {text!r}: must be x, y and z once, like 'y -x z'")
        if setup.dof > MOST_AXES:
            reason = f"has {MOST_AXES} axes; set dof = {setup.dof} to {MOST_AXES} or less"
            raise DeviceError(f"device.plugin = {setup.device.plugin!r}: {reason}")
        used = found[: setup.dof]
        self._axes = [("xyz".index(axis), -1.0 if sign else 1.0) for sign, axis in used]

    def world(self, vector: Vector3) -> Value:
        """Return a vector of the device in axes of the world."""
        return value(tuple(sign * vector[at] for at, sign in self._axes))

    def on_hand(self, f_m: Value) -> list[float]:
        """Return the force on the hand, ``-f_m``, in axes of the device [N]."""
        force = [0.0, 0.0, 0.0]
        for (at, sign), each in zip(self._axes, flatten(f_m), strict=True):
            force[at] = -sign * float(each)
        return force


class VendorDevice(ABC, Generic[P]):
    """The part of a device that is alike for all; the force of its hand is not known."""

    def __init__(self, name: str, setup: DeviceSetup, kind: type[P], params: P | None) -> None:
        """Make a device from ``params``; else those that the node was given, or the defaults."""
        node = self._node = setup.node
        self._params = p = params or (kind() if node is None else declare(node, name, kind))
        self._name, self._tick_s = name, setup.tick_s
        known = self._profile = profile_of(name, p.model)
        self._axes = Axes(f"{name}.axes", p.axes, setup)
        self._claim: socket.socket | None = None
        self._far = ""  # why a position cannot be one
        self.info = DeviceInfo(
            p.model, setup.dof, max_force=known.max_force_n,
            continuous_force=known.continuous_force_n, apparent_mass=known.apparent_mass_kg,
            workspace_m=known.workspace_m, encoder_step_m=known.encoder_step_m,
            velocity="estimated",
        )  # fmt: skip
        zero = self._zero = value((0.0,) * setup.dof)
        self._sample = DeviceSample(x=zero, xd=zero, f_h=zero, valid=False)

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
        self._tell(f"{text}; profile: {'; '.join(self._profile.lines())}")

    def _give_back(self) -> None:
        if self._claim is not None:
            self._claim.close()
        self._claim = None

    def _tell(self, text: str) -> None:
        """Write a line to the log of the node, where there is one."""
        if self._node is not None:
            self._node.get_logger().info(f"{self.info.model}: {text}")

    def _sense(self, x: Vector3, xd: Vector3, centre_m: Vector3 = ORIGIN) -> None:
        """Take a motion in axes of the device over; it is invalid where it cannot be metres."""
        from_centre = [a - b for a, b in zip(x, centre_m, strict=True)]
        self._far = beyond(from_centre, self.info.workspace_m)
        valid = not self._far and all(map(math.isfinite, (*x, *xd)))
        self._sample.valid = valid
        if valid:
            self._sample.x, self._sample.xd = self._axes.world(from_centre), self._axes.world(xd)

    def _refuse_far(self) -> None:
        if self._far:
            raise DeviceError(f"{self._name}: {self._far}")

    @abstractmethod
    def write(self, f_m: Value) -> None:
        """Push the hand with ``-f_m`` until the next call."""

    def couple(self) -> None:
        """Do nothing: a person needs no start."""

    def stop(self) -> None:
        """Set the force to zero."""
        self.write(self._zero)


class ThreadedDevice(VendorDevice[P]):
    """A device that a thread of its own serves, through a mailbox."""

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self._box = Mailbox()

    def _await_first(self) -> None:
        """Wait for the first measurement; DeviceError where none comes, or a wrong one."""
        until = time.monotonic() + OPEN_S
        while self._box.newest is None and time.monotonic() < until:
            time.sleep(0.001)
        if not self.read(time.monotonic_ns()).fresh:
            raise DeviceError(f"{self._name}: no measurement in {OPEN_S:g} s; see the device")
        self._refuse_far()

    def read(self, due_ns: int) -> DeviceSample:
        """Return the newest measurement of the thread; an old one is invalid."""
        sample, newest = self._sample, self._box.newest
        sample.fresh = newest is not None and newest.at_ns != sample.measured_ns
        if newest is not None and sample.fresh:
            self._sense(newest.x, newest.xd, self._profile.centre_m)
            sample.valid &= newest.trusted
            sample.measured_ns = newest.at_ns
        elif sample.measured_ns is not None:
            sample.valid &= due_ns - sample.measured_ns <= STALE_NS
        return sample

    def write(self, f_m: Value) -> None:
        """Push the hand from the thread's next turn on, until the next call here."""
        self._box.ask(self._axes.on_hand(f_m), time.monotonic_ns())


def library_calls(
    device: str, path: str, names: Sequence[str], signatures: Mapping[str, Any], sdk: str
) -> Calls:
    """Return the calls of the library at ``path``, else of the first name that the system finds;
    DeviceError where it, or one of them, is not there. Signatures: types of result and arguments.
    """
    where, problem = f"{device}.library = {path!r}", ""
    for name in (path,) if path else names:
        try:
            library = CDLL(name)
            break
        except OSError as error:
            problem = problem or str(error)
    else:
        raise DeviceError(f"{where}: {problem}; install the {sdk} and name the file")
    if lacks := [name for name in signatures if not hasattr(library, name)]:
        raise DeviceError(f"{where}: lacks {', '.join(lacks)}; install a newer {sdk}")
    calls: Calls = {}
    for name, (result, arguments) in signatures.items():
        call = calls[name] = getattr(library, name)
        call.restype, call.argtypes = result, list(arguments)
    return calls
