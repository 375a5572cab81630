# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The interface between the force loop and a haptic device.

A device speaks SI units in the axes of the world (axis 0 is +x, along which the users meet) and
converts its own inside. Limits of force, slope and speed are not its business: the safety layer
stands between controller and device, the same for all devices. Vendor libraries are imported in
``open``, not at the top of a module, so that a list of what is installed never fails. A
laboratory adds a device by a package of its own that names a :data:`DeviceFactory` as an entry
point of the group ``pmwvc.devices``; nothing here changes.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, Protocol, TypeAlias

from pmwvc_core.errors import DeviceError
from pmwvc_core.frame.rows import STALE_NS, DeviceSample
from pmwvc_core.numeric import Value
from pmwvc_core.params import DeviceParams, OperatorParams, TaskParams
from pmwvc_core.plugins import PluginGroup

__all__ = [
    "STALE_NS",
    "DeviceFactory",
    "DeviceInfo",
    "DeviceSample",
    "DeviceSetup",
    "HapticDevice",
]


@dataclass(frozen=True, slots=True)
class DeviceInfo:
    """The capabilities of a device.

    All of it is used: the forces bound the safety limits; beyond the workspace only damping is
    rendered; the mass decides whether the rendered damping is stable at the tick rate, mass and
    encoder step what the port of the hand may give out where velocities are ``estimated``. They
    are compared with ``device.*``, on which predictions rest.

    ``pacing`` is the owner of the clock: ``host`` (the loop reads and writes), ``exchange`` (one
    round trip is one tick), ``device`` (a vendor's thread fills a mailbox) or ``event`` (samples
    come irregularly, as over a topic). The loop watches the age of the samples whatever it is.
    """

    model: str
    dof: int  # axes sensed and actuated
    serial: str = ""
    max_force: float | None = None  # [N] peak, None: not known
    continuous_force: float | None = None  # [N] for as long as one likes
    apparent_mass: float | None = None  # [kg]
    apparent_damping: float | None = None  # [N s/m]
    workspace_m: float | None = None  # half extent [m]
    encoder_step_m: float | None = None  # resolution of the position [m]
    pacing: Literal["host", "exchange", "device", "event"] = "host"
    velocity: Literal["measured", "estimated"] = "measured"
    hand_force_known: bool = False


@dataclass(frozen=True, slots=True)
class DeviceSetup:
    """The setup that a device is made for.

    ``start_m`` is where a device that can choose starts: in front of the user's face of the
    object. ``node`` is the ROS node, for devices that talk over topics; it is ``None`` without
    ROS.
    """

    dof: int
    tick_s: float
    side: int  # of the object the user is on: -1 pushes towards +x
    half_width_m: float  # of the object [m]
    start_m: float  # on axis 0 [m]
    seed: int
    device: DeviceParams
    operator: OperatorParams
    task: TaskParams
    node: Any = None


class HapticDevice(Protocol):
    """One device. All calls but ``open`` and ``close`` come from the loop's thread."""

    info: DeviceInfo

    def open(self) -> None:
        """Make the device ready, force zero.

        Raises
        ------
        DeviceError
            With cause and remedy.
        """

    def read(self, due_ns: int) -> DeviceSample:
        """Return what is sensed at the tick due at ``due_ns`` (monotonic clock), of replies that
        wait the newest; never wait longer than a tick.

        The sample may be the same object at every call: use it before the next one.
        """

    def write(self, f_m: Value) -> None:
        """Apply the force until the next call [N]: the device pushes the hand with ``-f_m``."""

    def couple(self) -> None:
        """Note that forces are rendered from now on: a simulated hand starts here."""

    def stop(self) -> None:
        """Set the force to zero; may be called more than once; called on every way out."""

    def close(self) -> None:
        """Give the device back."""


DeviceFactory: TypeAlias = Callable[[DeviceSetup], HapticDevice]
PLUGINS = PluginGroup(
    "pmwvc.devices", "device.plugin", "a device",
    calls=("open", "read", "write", "couple", "stop", "close"), attributes=("info",),
    error=DeviceError,
)  # fmt: skip


def make_device(name: str, setup: DeviceSetup) -> HapticDevice:
    """Make the device of a plug-in; it is not opened yet. DeviceError where there is no such
    plug-in (naming those there are), or what it makes is no device with that many axes.
    """
    device: HapticDevice = PLUGINS.make(name, setup)
    if device.info.dof != setup.dof:
        raise DeviceError(
            f"device.plugin = {name!r} has {device.info.dof} axes where dof = {setup.dof} is "
            "asked for"
        )
    return device
