# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""An arm of LeRobot: any Teleoperator with ``get_action`` and ``send_feedback``, in a thread.

Rows (Denavit and Hartenberg): name, a [m], alpha [rad], d [m], theta [rad] at 0, rad per unit::

    T = prod Rz(theta) Tz(d) Tx(a) Rx(alpha),   v = J dq/dt,   tau = J^T f,   tau . dq/dt = f . v
"""

import contextlib
import importlib.util
import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pmwvc_core.errors import PLUGIN_ERRORS, DeviceError, reason
from pmwvc_core.numeric import Array
from pmwvc_core.params.fields import Validated, fixed
from pmwvc_core.plugins import refused
from pmwvc_master.devices import DeviceSetup
from pmwvc_master.devices.profile import ORIGIN
from pmwvc_master.devices.vendor import Measurement, ThreadedDevice

PAUSE_S = 1.0  # after an error


def hand_of(joints: Sequence[Any], action: Array) -> tuple[Array, Array]:
    """Return position (3,) and Jacobian (3, joints) of the hand, in axes of the base."""
    x, turned, poles = np.zeros(3), np.eye(3), []
    for (_, a, alpha, d, zero, scale), units in zip(joints, action, strict=True):
        poles.append((turned[:, 2], x))
        theta = zero + scale * units
        c, s, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
        x = x + turned @ [a * c, a * s, d]
        turned = turned @ [[c, -s * ca, s * sa], [s, c * ca, -c * sa], [0.0, sa, ca]]
    return x, np.array([np.cross(z, x - at) for z, at in poles]).T


@dataclass(frozen=True)
class LerobotParams(Validated):
    """Parameters of the node besides those of every device."""

    model: str = fixed("", "-", "YAML file with the arm's profile: its joints, what it can do")
    teleoperator: str = fixed("", "-", "its class, as module:name")
    config: str = fixed("", "-", "its configuration, as 'port=/dev/ttyACM0 id=left'")
    feedback: str = fixed("torque", "-", "end of the names of a joint's feedback, in N m")


class LerobotDevice(ThreadedDevice):
    """One arm."""

    def __init__(self, setup: DeviceSetup, params: LerobotParams | None = None) -> None:
        super().__init__("lerobot", setup, LerobotParams, params)
        with refused(f"joints of {self._params.model}", DeviceError):
            self._joints = [(n, +a, +b, +c, +d, +e) for n, a, b, c, d, e in self._profile.joints]
            self._names = [str(name) for name, *_ in self._joints]
            self._keys = [f"{name}.{self._params.feedback}" for name in self._names]
        self._arm: Any = None
        self._ended, self._thread = threading.Event(), threading.Thread(target=self._serve)

    @staticmethod
    def look() -> str:
        """Return what there is; DeviceError without the library."""
        if importlib.util.find_spec("lerobot") is None:
            raise DeviceError("LeRobot is not here: pip install lerobot")
        return "library there"

    def open(self) -> None:
        """Make and connect the arm, see that it takes forces, start its thread."""
        p, (module, _, name) = self._params, self._params.teleoperator.partition(":")
        where = f"lerobot.teleoperator = {p.teleoperator!r}, lerobot.config = {p.config!r}"
        with refused(where, DeviceError, "opened"):
            kind = getattr(importlib.import_module(module), name)
            config = dict(each.split("=", 1) for each in p.config.split())
            self._take(name, config.get("port") or config.get("id", ""))
            self._arm = kind(kind.config_class(**config))
            self._arm.connect(calibrate=False)
            if not self._arm.is_calibrated:
                raise DeviceError(f"{where} is not calibrated: lerobot-calibrate")
            if lacks := set(self._keys) - set(takes := self._arm.feedback_features):
                raise DeviceError(f"{where} takes no {min(lacks)}, but {[*takes] or 'nothing'}")
            self._exchange()
        self._thread.start()
        self._await_first()

    def _exchange(self) -> None:
        """Read the joints, and set the torques of the force."""
        action, now_ns = self._arm.get_action(), time.monotonic_ns()
        units = np.array([float(action[f"{name}.pos"]) for name in self._names])
        x, jacobian = hand_of(self._joints, units)
        before = self._newest or Measurement(0, x.tolist(), ORIGIN)
        xd = (x - before.x) / ((now_ns - before.at_ns) * 1e-9)
        self._newest = Measurement(now_ns, x.tolist(), xd.tolist())
        self._push(np.nan_to_num(jacobian.T @ self._force(now_ns)))  # no force of no number

    def _push(self, torques: Array) -> None:
        self._arm.send_feedback(dict(zip(self._keys, torques.tolist(), strict=True)))

    def _serve(self) -> None:
        while not self._ended.is_set():
            try:
                self._exchange()
            except PLUGIN_ERRORS as error:  # whatever it raises; samples get old meanwhile
                self._tell(reason(error))
                self._let_go()
                self._ended.wait(PAUSE_S)

    def _let_go(self) -> None:
        with contextlib.suppress(*PLUGIN_ERRORS):
            self._push(np.zeros(len(self._names)))

    def close(self) -> None:
        """End the thread, take the torques away, let go of the arm."""
        self._ended.set()
        if self._thread.is_alive():
            self._thread.join()
        if self._arm is not None:
            self._let_go()
            with contextlib.suppress(*PLUGIN_ERRORS):
                self._arm.disconnect()
        self._give_back()
