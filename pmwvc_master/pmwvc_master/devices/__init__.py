# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Haptic devices behind one interface; each is an entry point of the group ``pmwvc.devices``."""

from pmwvc_core.frame.device_sample import STALE_NS, DeviceSample
from pmwvc_master.devices.interface import DeviceFactory, DeviceInfo, DeviceSetup, HapticDevice

__all__ = [
    "STALE_NS",
    "DeviceFactory",
    "DeviceInfo",
    "DeviceSample",
    "DeviceSetup",
    "HapticDevice",
]
