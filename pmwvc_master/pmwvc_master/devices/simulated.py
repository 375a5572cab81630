# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The simulated device with a simulated hand on it.

Time passes on the loop's grid: a read advances the device from the last read to now, tick by
tick, with the force written last held. A tick that the loop missed passes too, as it would on a
real device, but not more than ``CATCH_UP_S`` at once. The hand aims at what it sees: its equations
are those behind ``device.scale``.
"""

from pmwvc_core.ends.inbox import value
from pmwvc_core.ends.user_end import CATCH_UP_S, DevicePlant
from pmwvc_core.numeric import Value
from pmwvc_core.params.behind import scaled
from pmwvc_core.plant.hand import Place
from pmwvc_core.plant.hands import make_hand
from pmwvc_master.devices import DeviceInfo, DeviceSample, DeviceSetup
from pmwvc_master.devices.ros_topic import HandTopics


class SimulatedDevice:
    """A mass with a hand; see :mod:`pmwvc_core.plant` for the equations of both."""

    def __init__(self, setup: DeviceSetup) -> None:
        self.info = DeviceInfo(
            model="simulated", dof=setup.dof, apparent_mass=setup.device.mass,
            apparent_damping=setup.device.damping, workspace_m=setup.device.workspace_m,
            encoder_step_m=setup.device.encoder_step_m or None,
            velocity="measured" if setup.device.velocity == "exact" else "estimated",
            hand_force_known=True,
        )  # fmt: skip
        self._tick_ns = round(setup.tick_s * 1e9)
        self._catch_up = max(1, round(CATCH_UP_S / setup.tick_s))
        at = Place(setup.side, setup.half_width_m, setup.start_m, setup.tick_s, setup.dof)
        hand, scale = make_hand(setup.operator, setup.task, at), setup.device.scale
        self._plant = DevicePlant(scaled(setup.device, scale), hand, at.start, tick_s=at.tick_s)
        self._scale = value((*(scale,) * 3, 1.0, 1.0, 1.0)[: setup.dof])
        self._sample = DeviceSample()
        if setup.node is not None and setup.operator.is_remote:
            self._plant.listen(HandTopics(setup).take)
        self._coupled = False
        self._f_m: Value = 0.0
        self._last_ns: int | None = None

    def open(self) -> None:
        """Nothing to open."""

    def read(self, due_ns: int) -> DeviceSample:
        """Let the time up to ``due_ns`` pass, then return state and hand force."""
        if self._last_ns is not None:
            ticks = (due_ns - self._last_ns + self._tick_ns // 2) // self._tick_ns
            for missed in range(min(ticks, self._catch_up)):
                if missed:
                    self._plant.sense(self._coupled)
                self._plant.step(self._f_m)
        self._last_ns = due_ns
        seen, own = self._plant.sense(self._coupled), self._sample
        own.x, own.xd = seen.x / self._scale, seen.xd / self._scale
        own.f_h, own.work = seen.f_h * self._scale, seen.work
        return own

    def write(self, f_m: Value) -> None:
        """Hold the force until the next tick."""
        self._f_m = f_m / self._scale

    def couple(self) -> None:
        """Let the hand begin."""
        self._coupled = True

    def stop(self) -> None:
        """Set the force to zero."""
        self._f_m = 0.0

    def close(self) -> None:
        """Nothing to close."""
