# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The declaration of a device, compared with the parameters of its user.

The force limit is the smaller of the user's and the device's own. The rendered damping b xd, held
for a tick on a mass m, multiplies the velocity by 1 - b T_c/m per tick: it overshoots from
b T_c/m = 1 and is unstable from 2. Predictions rest on ``device.mass``, ``device.workspace_m`` and
``device.encoder_step_m``. Behind counts the port of the hand is bounded only up to some b T_c/m
(:mod:`pmwvc_core.master.count_bound`).
"""

import dataclasses
import math
from collections.abc import Iterator

from pmwvc_core.errors import DeviceError
from pmwvc_core.master.count_bound import count_bound
from pmwvc_core.params import DeviceParams, MasterParams, SafetyParams
from pmwvc_core.wave.impedance import impedance_of, largest
from pmwvc_master.devices import DeviceInfo

PACINGS = ("host", "exchange", "device", "event")
SIMILAR = 0.1  # relative difference of masses and workspaces that no prediction minds


def limits_of(info: DeviceInfo, safety: SafetyParams) -> SafetyParams:
    """Return the safety limits within what the device declares; DeviceError if that cannot be."""
    positive = ("max_force", "continuous_force", "apparent_mass", "workspace_m", "encoder_step_m")
    for name in positive:
        value = getattr(info, name)
        if value is not None and not 0.0 < value < math.inf:
            raise DeviceError(f"{info.model}: declares {name} = {value!r}: must be > 0 or None")
    if info.pacing not in PACINGS:
        raise DeviceError(
            f"{info.model}: declares pacing = {info.pacing!r}: must be one of {', '.join(PACINGS)}"
        )
    declared = [f for f in (info.max_force, info.continuous_force) if f is not None]
    return dataclasses.replace(safety, max_force=min([safety.max_force, *declared]))


def warnings_of_device(
    info: DeviceInfo, master: MasterParams, device: DeviceParams, *, waves: bool, strict: bool
) -> Iterator[str]:
    """Yield what a user should know of a device before a hand is on it."""
    mass = info.apparent_mass
    if waves and mass is not None:
        impedance = largest(impedance_of(master))
        ratio = impedance * master.tick_s / mass
        if ratio >= 1.0:
            yield (
                f"b T_c/m = {ratio:.2f} on this device ({impedance:g} N s/m, "
                f"{master.tick_s * 1e3:g} ms, {mass:g} kg): the rendered damping "
                f"{'is unstable' if ratio >= 2.0 else 'overshoots'} unless the hand adds mass or "
                f"damping; below 1 needs master.impedance < {mass / master.tick_s:g} N s/m"
            )
    step_m = info.encoder_step_m or device.encoder_step_m
    if strict and step_m > 0.0 and info.velocity == "estimated":
        real = dataclasses.replace(device, mass=mass or device.mass, encoder_step_m=step_m)
        yield count_bound(master, real).text
    for name, assumed, declared, unit in (
        ("mass", device.mass, mass, "kg"),
        ("damping", device.damping, info.apparent_damping, "N s/m"),
        ("workspace_m", device.workspace_m, info.workspace_m, "m"),
        ("encoder_step_m", device.encoder_step_m, info.encoder_step_m, "m"),
    ):
        if declared is not None and abs(assumed - declared) > SIMILAR * declared:
            yield (
                f"device.{name} = {assumed:g} {unit}, the device declares {declared:g} {unit}: "
                f"predictions rest on the former; set device.{name} = {declared:g}"
            )
