# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Which kinds of device there are, what each finds on this machine, and how to get what it lacks.

A plug-in may have ``look()``: a text of what is there, or a DeviceError with what is missing.
"""

import os
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from pmwvc_core.errors import DeviceError, PmwvcError
from pmwvc_core.plugins import installed
from pmwvc_master.devices import PLUGINS

USB, NODES = Path("/sys/bus/usb/devices"), Path("/dev/bus/usb")


class DeviceLine(NamedTuple):
    """A text about a device, and whether all is as it should be."""

    right: bool
    text: str


def listed() -> Iterator[DeviceLine]:
    """Yield a line for each kind of device that is installed."""
    for name in installed(PLUGINS.group):
        try:
            factory = PLUGINS.load(name)
            text = factory.look() if hasattr(factory, "look") else "installed"
            yield DeviceLine(True, f"{name}: {text}")
        except PmwvcError as error:
            yield DeviceLine(False, f"{name}: {error}")


def plugged_in(vendor: str) -> str:
    """Return how many USB devices a vendor has here; DeviceError for none, or no permission."""
    folders = [each.parent for each in sorted(USB.glob("*/idVendor")) if _read(each) == vendor]
    if not folders:
        raise DeviceError(f"no USB device of the vendor {vendor}: plug it in and switch it on")
    for folder in folders:
        path = NODES / _read(folder / "busnum").zfill(3) / _read(folder / "devnum").zfill(3)
        if not os.access(path, os.R_OK | os.W_OK):
            rule = f'SUBSYSTEM=="usb", ATTR{{idVendor}}=="{vendor}", MODE="0666"'
            text = f"a file /etc/udev/rules.d/90-haptic.rules with the line {rule}"
            raise DeviceError(f"{path} may not be opened: make {text}, and plug it in again")
    return f"{len(folders)} plugged in"


def _read(file: Path) -> str:
    return file.read_text("utf-8").strip()
