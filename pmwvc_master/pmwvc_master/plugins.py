# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Devices by name: entry points of the group ``pmwvc.devices``.

A laboratory adds a device by installing a package of its own that names a factory
``DeviceSetup -> HapticDevice`` in that group; nothing here changes.
"""

from pmwvc_core.errors import DeviceError
from pmwvc_core.plugins import PluginGroup
from pmwvc_master.devices.interface import DeviceSetup, HapticDevice

PLUGINS = PluginGroup(
    "pmwvc.devices",
    "device.plugin",
    "a device",
    calls=("open", "read", "write", "couple", "stop", "close"),
    attributes=("info",),
    error=DeviceError,
)


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
