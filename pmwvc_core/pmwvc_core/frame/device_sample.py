# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The sample of a device at one tick."""

from dataclasses import dataclass

from pmwvc_core.numeric import Value

LATE_NS = 5_000_000  # a sample older than this is named in the diagnostics
STALE_NS = 20_000_000  # one older than this is none: the device is silent


@dataclass(slots=True)
class DeviceSample:
    """Motion and forces that a device senses at one tick.

    ``valid`` is False where position or velocity cannot be trusted: the loop then asks for no
    force. ``fresh`` is False where nothing new came since the last read, whatever the pacing, and
    ``measured_ns`` the time of the measurement on the monotonic clock, None for that of the read.
    ``f_h`` is the hand's force on the device, zero where
    ``hand_force_known`` is False. ``work`` is for devices that know their true motion, as a
    simulated one does: the work of the controller's force against the hand and of the hand's
    force on the device since the start [J]. Where it is None the loop counts the motion measured.
    """

    x: Value = 0.0  # [m]
    xd: Value = 0.0  # [m/s]
    f_h: Value = 0.0  # [N]
    valid: bool = True
    work: tuple[Value, Value] | None = None
    fresh: bool = True
    measured_ns: int | None = None
