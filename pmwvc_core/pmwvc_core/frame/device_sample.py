# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The sample of a device at one tick."""

from dataclasses import dataclass

from pmwvc_core.numeric import Value

STALE_S = 0.02  # without a fresh sample of a device that marks them: it is silent


@dataclass(slots=True)
class DeviceSample:
    """Motion and forces that a device senses at one tick.

    ``valid`` is False where position or velocity cannot be trusted: the loop then asks for no
    force. ``fresh`` is False where nothing new came since the last read; only devices with pacing
    ``device`` or ``event`` need to set it. ``f_h`` is the hand's force on the device, zero where
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
