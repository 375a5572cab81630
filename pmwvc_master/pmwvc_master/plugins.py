# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Devices by name: entry points of the group ``pmwvc.devices``.

A laboratory adds a device by installing a package of its own that names a factory
``DeviceSetup -> HapticDevice`` in that group; nothing here changes.
"""

from importlib.metadata import EntryPoint, entry_points

from pmwvc_core.errors import DeviceError, PmwvcError
from pmwvc_master.devices.interface import DeviceSetup, HapticDevice

GROUP = "pmwvc.devices"
_CALLS = ("open", "read", "write", "couple", "stop", "close")


def installed() -> dict[str, EntryPoint]:
    """Return the installed device plug-ins by name, without importing any."""
    return {point.name: point for point in sorted(entry_points(group=GROUP))}


def required(name: str) -> EntryPoint:
    """Return an installed plug-in, without importing it.

    Raises
    ------
    DeviceError
        If there is none of this name; names those there are.
    """
    points = installed()
    if name not in points:
        there = ", ".join(points) or "none"
        raise DeviceError(
            f"device.plugin = {name!r}: not installed; installed are: {there}. "
            f"A plug-in is a package with an entry point in the group {GROUP!r}"
        )
    return points[name]


def make_device(name: str, setup: DeviceSetup) -> HapticDevice:
    """Make the device of a plug-in; it is not opened yet.

    Raises
    ------
    DeviceError
        If there is no such plug-in (naming those there are), if it cannot be imported or made
        (with the reason), or if what it makes is not a device.
    """
    point = required(name)
    try:
        factory = point.load()
    except Exception as error:  # whatever a foreign package raises while it is imported
        raise DeviceError(f"{_where(point)} cannot be imported: {_reason(error)}") from error
    try:
        device: HapticDevice = factory(setup)
    except PmwvcError:
        raise
    except Exception as error:  # whatever a foreign factory raises
        raise DeviceError(f"{_where(point)} cannot be made: {_reason(error)}") from error
    missing = [call for call in _CALLS if not callable(getattr(device, call, None))]
    if missing or not hasattr(device, "info"):
        lacks = ", ".join([*missing, *([] if hasattr(device, "info") else ["info"])])
        raise DeviceError(f"{_where(point)} is not a device: it lacks {lacks}")
    if device.info.dof != setup.dof:
        raise DeviceError(
            f"{_where(point)} has {device.info.dof} axes where dof = {setup.dof} is asked for"
        )
    return device


def _where(point: EntryPoint) -> str:
    return f"device.plugin = {point.name!r} ({point.value})"


def _reason(error: Exception) -> str:
    return f"{type(error).__name__}: {error}"
