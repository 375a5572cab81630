# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What devices of vendors have in common: a profile, axes, parameters, one master each."""

import math
import re
import socket
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Generic, TypeVar

from pmwvc_core.ends.inbox import value
from pmwvc_core.errors import DeviceError
from pmwvc_core.numeric import Value, flatten
from pmwvc_core.params.fields import Validated
from pmwvc_core.runtime.parameters import declare
from pmwvc_master.devices import DeviceInfo, DeviceSample, DeviceSetup
from pmwvc_master.devices.plausible import beyond
from pmwvc_master.devices.profile import ORIGIN, Vector3, profile_of

MOST_AXES = 3


@dataclass(frozen=True)
class VendorParams(Validated):
    """What the parameters of each have: the model of its profile, the text of ``Axes``."""

    model: str = ""
    axes: str = ""


P = TypeVar("P", bound=VendorParams)


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

    def _take(self, serial: str) -> None:
        """Take a device for this process while it lives; DeviceError where another one has it."""
        if self._claim is not None:
            return
        claim = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        try:
            claim.bind(f"\0pmwvc.{self._name}.{serial}")
        except OSError:
            claim.close()
            text = "another master has it (their forces would add); name another one"
            raise DeviceError(f"{self._name}: device {serial}: {text}") from None
        self._claim = claim
        self._tell(f"device {serial}; profile: {'; '.join(self._profile.lines())}")

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
