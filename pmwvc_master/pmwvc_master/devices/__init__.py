# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The interface between the force loop and a haptic device, and the comparison of what a device
declares with the parameters of its user.

A device speaks SI units in axes of its own, and declares which of them are x, y and z of the world
(axis 0 is +x, along which the users meet). Limits of force, slope and speed are not its business:
the safety layer stands between controller and device, the same for all. Vendor libraries are
imported in ``open``, not at the top of a module, so that a list of what is installed never fails.
A laboratory adds a device by a package of its own that names a :data:`DeviceFactory` as an entry
point of the group ``pmwvc.devices``; nothing here changes.
"""

import dataclasses
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Literal, Protocol, TypeAlias

from pmwvc_core.errors import DeviceError
from pmwvc_core.frame import STALE_NS, DeviceSample
from pmwvc_core.master.count_bound import count_bound
from pmwvc_core.numeric import AXES, Value
from pmwvc_core.params import DeviceParams, MasterParams, OperatorParams, SafetyParams, TaskParams
from pmwvc_core.params.behind import scaled
from pmwvc_core.plugins import PluginGroup
from pmwvc_core.wave.impedance import impedance_of, largest

__all__ = [
    "STALE_NS", "DeviceFactory", "DeviceInfo", "DeviceSample", "DeviceSetup", "HapticDevice",
]  # fmt: skip


@dataclass(frozen=True, slots=True)
class DeviceInfo:
    """The capabilities of a device.

    The peak bounds the safety limits; beyond the workspace only damping is rendered; the mass
    decides whether the rendered damping is stable at the tick rate, mass and encoder step what the
    hand port may give out where velocities are ``estimated``. They are compared with ``device.*``.
    """

    model: str
    dof: int  # axes sensed and actuated
    max_force: float | None = None  # [N] peak (the continuous one where not known)
    continuous_force: float | None = None  # [N] for as long as one likes
    apparent_mass: float | None = None  # [kg]
    apparent_damping: float | None = None  # [N s/m]
    workspace_m: float | None = None  # half extent [m]
    encoder_step_m: float | None = None  # resolution of the position [m]
    velocity: Literal["measured", "estimated"] = "measured"
    hand_force_known: bool = False
    axes: str = ""  # of the device along x, y, z of the world, like "y -x z"; empty: the same
    buttons: int = 0
    max_torque: float | None = None  # [N m] peak; 0: of six axes only forces are rendered


@dataclass(frozen=True, slots=True)
class DeviceSetup:
    """What a device is made for. One that can choose starts at ``start_m``, in front of the user's
    face of the object. ``node`` is the ROS node, for topics, parameters, log; or ``None``.
    """

    dof: int
    tick_s: float
    side: int  # of the object the user is on: -1 pushes towards +x
    half_width_m: float  # of the object [m]
    start_m: float  # on axis 0 [m]
    lever_m: float  # axes 4 to 6 are a turn times this
    device: DeviceParams
    operator: OperatorParams
    task: TaskParams
    node: Any = None
    max_slew_n_s: float = SafetyParams.max_slew  # of the device's force


class HapticDevice(Protocol):
    """One device. All calls but ``open`` and ``close`` come from the loop's thread."""

    info: DeviceInfo

    def open(self) -> None:
        """Make the device ready, force zero; DeviceError with cause and remedy."""

    def read(self, due_ns: int) -> DeviceSample:
        """Return what is sensed at the tick due at ``due_ns`` (monotonic clock), of replies that
        wait the newest; never wait longer than a tick. It may be the same object at every call.
        """

    def write(self, f_m: Value) -> None:
        """Apply the force until the next call [N]: the device pushes the hand with ``-f_m``."""

    def couple(self) -> None:
        """Note that forces are rendered from now on: a simulated hand starts here."""

    def stop(self) -> None:
        """Set the force to zero; may be called more than once; called on every way out."""

    def close(self) -> None:
        """Give the device back; called where ``open`` failed, too."""


DeviceFactory: TypeAlias = Callable[[DeviceSetup], HapticDevice]
PLUGINS = PluginGroup(
    "pmwvc.devices", "device.plugin", "a device",
    calls=(("open",), ("read",), ("write",), ("couple",), ("stop",), ("close",)),
    attributes=("info",), error=DeviceError,
)  # fmt: skip


SIMILAR = 0.1  # relative difference of masses and workspaces that no prediction minds
POSITIVE = ("max_force", "continuous_force", "max_torque", "apparent_mass", "workspace_m",
            "encoder_step_m")  # fmt: skip
NO_TORQUE = "max_torque", 0.0


def limits_of(info: DeviceInfo, safety: SafetyParams, lever_m: float = math.inf) -> SafetyParams:
    """Return the safety limits within what the device declares; DeviceError if that cannot be."""
    for name in POSITIVE:
        value = getattr(info, name)
        if value is not None and not 0.0 < value < math.inf and (name, value) != NO_TORQUE:
            raise DeviceError(f"{info.model}: declares {name} = {value!r}: must be > 0 or None")
    peak = info.max_force or info.continuous_force or math.inf
    safety = dataclasses.replace(safety, max_force=min(safety.max_force, peak))
    if not info.max_torque:
        return safety
    torque = min(safety.torque_n_m(lever_m), info.max_torque)
    return dataclasses.replace(safety, max_torque=torque)


def warnings_of_device(
    info: DeviceInfo, master: MasterParams, device: DeviceParams, *, force_n: float, waves: bool,
    strict: bool, torque_n_m: float,
) -> Iterator[str]:  # fmt: skip
    """Yield what a user should know of a device before a hand is on it.

    The rendered damping b xd, held for a tick on a mass m, multiplies the velocity by 1 - b T_c/m
    per tick: it overshoots from b T_c/m = 1 and is unstable from 2. Behind counts the port of the
    hand is bounded only up to some b T_c/m (:mod:`pmwvc_core.master.count_bound`).
    """
    mass, lasting = info.apparent_mass, info.continuous_force
    if lasting is not None and force_n > lasting:
        text = "hold less, or lower safety.max_force"
        yield f"safety.max_force = {force_n:g} N: the device holds {lasting:g} N for long; {text}"
    if info.dof == AXES and info.max_torque is None and torque_n_m and not device.is_simulated:
        text = "the device declares no max_torque; set what its motors hold"
        yield f"safety.max_torque = {torque_n_m:g} N m, max_force at the lever: {text}"
    if waves and mass is not None:
        impedance = largest(impedance_of(master))
        ratio = impedance * device.scale**2 * master.tick_s / mass
        if ratio >= 1.0:
            yield (
                f"b T_c/m = {ratio:.2f} on this device ({impedance * device.scale**2:g} N s/m, "
                f"{master.tick_s * 1e3:g} ms, {mass:g} kg): the rendered damping "
                f"{'is unstable' if ratio >= 2.0 else 'overshoots'} unless the hand adds mass or "
                f"damping; below 1 needs master.impedance < {impedance / ratio:g} N s/m"
            )
    step_m = info.encoder_step_m or device.encoder_step_m
    if strict and step_m > 0.0 and info.velocity == "estimated":
        real = dataclasses.replace(device, mass=mass or device.mass, encoder_step_m=step_m)
        yield count_bound(master, scaled(real, device.scale)).text
    for name, assumed, declared, unit in (
        ("mass", device.mass, mass, "kg"),
        ("damping", device.damping, info.apparent_damping, "N s/m"),
        ("workspace_m", device.workspace_m, info.workspace_m, "m"),
        ("encoder_step_m", device.encoder_step_m, info.encoder_step_m, "m"),
    ):
        if declared is not None and abs(assumed - declared) > SIMILAR * declared:
            text = f"the device declares {declared:g} {unit}: predictions rest on the former"
            yield f"device.{name} = {assumed:g} {unit}, {text}; set device.{name} = {declared:g}"
