# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The work done at a device by the forces held between its samples."""

from pmwvc_core.numeric import Value, dot
from pmwvc_master.devices import DeviceSample


class DeviceWork:
    """Running sums of work [J].

    Attributes
    ----------
    device, hand
        Work of the device's force against the hand, and of the hand on the device [J].
    samples
        Samples of the device that were new.
    held
        Forces of device and hand since the last sample [N]; None before the first.
    """

    def __init__(self, *, hand_force_known: bool) -> None:
        self.device: Value = 0.0
        self.hand: Value = 0.0
        self._hand_force_known = hand_force_known
        self.samples = 0
        self.held: tuple[Value, Value] | None = None

    def moved(self, x: Value, sample: DeviceSample) -> None:
        """Take a sample; add the work since the last valid position [m]."""
        self.samples += sample.fresh
        if sample.work is not None:
            self.device, self.hand = sample.work
        elif sample.valid and self.held is not None:
            moved = sample.x - x
            f, f_h = self.held
            self.device = self.device + dot(f, moved)
            if self._hand_force_known:
                self.hand = self.hand + dot(f_h, moved)
