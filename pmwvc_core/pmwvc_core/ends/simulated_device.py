# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A simulated device with a hand on it, as a force loop meets it: the laws of ``plant`` with
their state. What is sensed at the start of a tick is the sample; then the controller's force is
held for the tick.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

from pmwvc_core.ends.inbox import value, vector
from pmwvc_core.frame import DeviceSample
from pmwvc_core.law.vectors import Vector, zero
from pmwvc_core.numeric import Value
from pmwvc_core.params import DeviceParams
from pmwvc_core.plant.device import device_step, resting_device, simulated_params
from pmwvc_core.plant.forces import hand_force
from pmwvc_core.plant.remote_hand import RemoteHand, remote_target
from pmwvc_core.unrolled import members, unrolled

# Time that a loop misses passes with the last force held, then the device stands still.
CATCH_UP_S = 0.1
Target: TypeAlias = Value | None  # of a remote hand [m]; None lets go


class DevicePlant:
    """A device and the hand on it; ParameterError where it starts outside its workspace."""

    def __init__(
        self, device: DeviceParams, hand: tuple[Any, Any], start: Vector, *, tick_s: float
    ) -> None:
        self._p = simulated_params(device, tick_s)
        self.s = resting_device(start, self._p)
        self.hand, self._of_hand = hand
        self._take: Callable[[], Sequence[Target]] | None = None
        self._axes, self._f_h = len(start), zero(start)
        self._device_step = unrolled(device_step, self._axes)
        self._hand_laws = members(hand_force, self._axes)
        self.sample = DeviceSample(value(self.s.read_x), value(self.s.read_xd), work=(0.0, 0.0))

    @property
    def remote(self) -> RemoteHand | None:
        """The hand that follows targets, if it is such a one."""
        hand = getattr(self.hand, "hand", self.hand)
        return hand if isinstance(hand, RemoteHand) else None

    def listen(self, take: Callable[[], Sequence[Target]]) -> None:
        """Have a hand ``from_outside`` follow the targets that a call returns, new ones each."""
        self.hand, self._of_hand, self._take = self.hand.hand, self._of_hand.hand, take

    def sense(self, acts: bool) -> DeviceSample:
        """Return the sample at the start of a tick; the hand, on the device, acts or waits."""
        hand = self.hand
        for target in self._take() if self._take else ():
            wanted = math.nan if target is None else target
            hand = remote_target(hand, vector(wanted, self._axes))
        law = self._hand_laws[type(hand)]
        self.hand, self._f_h = law(hand, self.s.x, self.s.xd, acts, self._of_hand)
        self.sample.f_h = value(self._f_h)
        return self.sample

    def step(self, f_m: Value) -> DeviceSample:
        """Advance one tick with both forces held; return the sample at its end."""
        f, sample = vector(f_m, self._axes), self.sample
        self.s, x, xd = self._device_step(self.s, self._f_h, f, self._p)
        sample.x, sample.xd = value(x), value(xd)
        sample.work = self.s.against_j, self.s.by_hand_j
        return sample
