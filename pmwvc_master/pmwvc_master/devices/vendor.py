# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What devices of vendors have in common: known models, axes, parameters of their own.

Peak force and workspace are declared where a source is at hand. None gives continuous force,
apparent mass or encoder step: measure them, and set ``safety.max_force`` and ``device.*``.
"""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, NamedTuple, TypeVar

from pmwvc_core.ends.inbox import value
from pmwvc_core.errors import DeviceError
from pmwvc_core.numeric import Value, flatten
from pmwvc_core.params.fields import Validated
from pmwvc_core.runtime.parameters import declare
from pmwvc_master.devices import DeviceInfo, DeviceSample, DeviceSetup

MOST_AXES = 3
FARTHEST_M = 1.0  # no hand gets farther from the origin of a device on a desk
Vector3 = Sequence[float]  # in the axes of the device
ORIGIN = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class VendorParams(Validated):
    """What the parameters of each have: the name of a profile, the text of ``Axes``."""

    model: str = ""
    axes: str = ""


P = TypeVar("P", bound=VendorParams)


class Profile(NamedTuple):
    """What is known of a model, and from where."""

    source: str
    workspace_m: float  # half extent
    max_force: float | None = None  # [N] peak
    centre_m: Vector3 = ORIGIN  # of the workspace
    types: tuple[int, ...] = ()  # as ``dhdGetSystemType`` returns them


_SDK = "Inverse SDK 3.5: radii of tutorial 06, rest position of the protocol page"
_CHAI3D = "CHAI3D, CDeltaDevices.cpp; types: dhdc.h of SDK 3.7"
_REST = (0.0, -0.12, 0.15)
HAPLY = {
    "inverse3": Profile(f"{_SDK}; force: chai3d_haply", 0.10, 10.0, _REST),
    "minverse": Profile(_SDK, 0.04, None, _REST),
}
FORCE_DIMENSION = {
    "omega.3": Profile(_CHAI3D, 0.075, 12.0, types=(33,)),
    "omega.6": Profile(_CHAI3D, 0.075, 12.0, types=(34, 36)),
    "omega.7": Profile(_CHAI3D, 0.075, 12.0, types=(35, 37)),
    "delta.3": Profile(_CHAI3D, 0.15, 20.0, types=(63,)),
    "delta.6": Profile(_CHAI3D, 0.15, 20.0, types=(64,)),
    "sigma.6+": Profile(_CHAI3D, 0.09, 12.0, types=(106, 107)),
    "sigma.7": Profile(_CHAI3D, 0.075, 12.0, types=(104, 105)),
    "falcon": Profile(_CHAI3D, 0.04, 8.0, types=(60,)),
}


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

    def world(self, vector: Vector3, origin: Vector3 = ORIGIN) -> Value:
        """Return a vector of the device, from ``origin``, in axes of the world."""
        return value(tuple(sign * (vector[at] - origin[at]) for at, sign in self._axes))

    def on_hand(self, f_m: Value) -> list[float]:
        """Return the force on the hand, ``-f_m``, in axes of the device [N]."""
        force = [0.0, 0.0, 0.0]
        for (at, sign), each in zip(self._axes, flatten(f_m), strict=True):
            force[at] = -sign * float(each)
        return force


class VendorDevice(Generic[P]):
    """The part of a device that is alike for all; the force of its hand is not known."""

    def __init__(
        self, name: str, setup: DeviceSetup, kind: type[P], params: P | None,
        models: Mapping[str, Profile],
    ) -> None:  # fmt: skip
        """Make a device from ``params``; else those that the node was given, or the defaults."""
        node = self._node = setup.node
        self._params = p = params or (kind() if node is None else declare(node, name, kind))
        self._tick_s, self._profile = setup.tick_s, models[p.model]
        self._axes = Axes(f"{name}.axes", p.axes, setup)
        self.info = DeviceInfo(
            p.model, setup.dof, max_force=self._profile.max_force,
            workspace_m=self._profile.workspace_m, velocity="estimated",
        )  # fmt: skip
        zero = self._zero = value((0.0,) * setup.dof)
        self._sample = DeviceSample(x=zero, xd=zero, f_h=zero, valid=False)

    def _tell(self, text: str) -> None:
        """Write a line to the log of the node, where there is one."""
        if self._node is not None:
            self._node.get_logger().info(f"{self.info.model}: {text}")

    def _sense(self, x: Vector3, xd: Vector3, centre_m: Vector3 = ORIGIN) -> None:
        """Take a motion in axes of the device over; it is invalid where it cannot be metres."""
        sample = self._sample
        sample.valid = all(abs(each) < FARTHEST_M for each in x) and all(map(math.isfinite, xd))
        if sample.valid:
            sample.x, sample.xd = self._axes.world(x, centre_m), self._axes.world(xd)

    def write(self, f_m: Value) -> None:
        """Push the hand with ``-f_m`` until the next call."""
        raise NotImplementedError

    def couple(self) -> None:
        """Do nothing: a person needs no start."""

    def stop(self) -> None:
        """Set the force to zero."""
        self.write(self._zero)
