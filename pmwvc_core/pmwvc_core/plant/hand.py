# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Hands: an arm that wants to be somewhere, and a grip that joins it to the handle.

Five parameters: the arm (mass m, position y) is drawn to its target x_t by stiffness k and damping
d; the grip (stiffness K, damping B) joins it to the handle (position x)::

    f_h = K (y - x) + B (yd - xd)
    m ydd = k (x_t - y) + d (xd_t - yd) + f_squeeze - f_h

**Why this adds no energy.** The grip force is held over a tick T, like every force on the device.
It is formed half a tick ahead, f_h = K e + (B + K T/2) w with e = y - x, w = yd - xd. The device
(held force, no damping of its own) and the arm (implicit midpoint, below) move by the mean of
their velocities times T, so e+ - e = T (w + w+)/2, and with beta = B + K T/2 the sum

    S = kinetic energies + K e^2/2 - (beta T/4) w^2

changes in a tick by -B T ((w + w+)/2)^2 and the work of the forces from outside: the spring is
lossless, the damper dissipates. S is positive as long as beta T/2 is less than the reduced mass of
arm and device, which is checked for a device of ``LIGHTEST_DEVICE`` and holds all the more for a
heavier or damped one. (A spring held without looking ahead adds K (e+ - e)^2/2 in every tick.) The
arm's own equation is integrated by the implicit midpoint rule: its spring stores exactly, so what
comes in is the work of the moving target and of the squeezing force, ``effort_j``.
"""

import numpy as np

from pmwvc_core.errors import ParameterError
from pmwvc_core.numeric import Array, Value, dot, maximum, where
from pmwvc_core.params import OperatorParams
from pmwvc_core.plant.devices import along_first_axis
from pmwvc_core.plant.forces import Operator, Setting, rows_of
from pmwvc_core.plant.task import Task

LIGHTEST_DEVICE = 0.05  # [kg]


class Grip:
    """The spring and damper between arm and handle, its force held over a tick.

    ``rate`` is the force per velocity, B + K T/2 [N s/m].
    """

    __slots__ = ("_stiffness", "rate")

    def __init__(self, params: OperatorParams, *, arm_mass: Value, tick_s: float) -> None:
        self._stiffness = params.grip_stiffness
        self.rate = params.grip_damping + 0.5 * tick_s * params.grip_stiffness
        lightest = 1.0 / (1.0 / LIGHTEST_DEVICE + 1.0 / arm_mass)  # reduced mass [kg]
        limit = 2.0 * lightest / tick_s
        if np.any(np.asarray(self.rate) >= limit):
            raise ParameterError(
                f"operator.grip_damping + grip_stiffness * tick_s / 2 = "
                f"{float(np.max(self.rate)):.4g} N s/m: must be < {float(np.min(limit)):.4g} "
                f"N s/m for a hand that is stable on a device of {LIGHTEST_DEVICE} kg; make the "
                f"grip softer or the tick shorter"
            )

    def force(self, lead: Value, rate: Value) -> Value:
        """Return the force on the handle [N]; the arm leads it by [m], and at a rate of [m/s]."""
        return self._stiffness * lead + self.rate * rate


class Hand(Operator):
    """The five-parameter hand carrying out a task.

    Its target is the task's plus its own side of the object, ``side * half_width``; it starts
    where the device is and closes the gap as the task demands. While it closes, a force grows that
    presses the arm inwards, along ``-side``: a handle fixed at the target is then held with
    ``squeeze`` (if the grip is at least as stiff as the arm).
    """

    SIGNALS = "y yd"
    MEMORY = "effort_j target _closed _closing _squeeze _facing"

    def __init__(self, params: OperatorParams, task: Task, at: Setting) -> None:
        tick_s, dof = at.tick_s, at.dof
        super().__init__(tick_s=tick_s, dof=dof)
        self._grip = Grip(params, arm_mass=params.mass, tick_s=tick_s)
        self._task, self._dof = task, dof
        self._face = at.side * at.half_width
        self._gap = at.start - self._face
        # The arm's spring takes k/K of it back when the grip gives way: press that much harder.
        firm = maximum(params.grip_stiffness, params.stiffness)
        give = params.stiffness / where(firm > 0.0, firm, 1.0)
        self._half_squeeze = 0.5 * (-at.side * params.squeeze * (1.0 + give))
        self._stiffness, self._damping = params.stiffness, params.damping
        self._twice_mass = 2.0 * params.mass
        self._inertia = (
            2.0 * params.mass + tick_s * params.damping + 0.5 * tick_s**2 * params.stiffness
        )
        self.y: Value = along_first_axis(at.start, dof)  # [m] of the arm
        self.yd: Value = 0.0 * self.y  # [m/s]
        self.effort_j: Value = 0.0  # [J] of the moving target and of the squeezing force
        self._closed = 0.0  # closed ratio before the present tick
        self._closing = 0.0  # and after it
        self._squeeze: Value = 0.0
        self.target: Value = self._aim(0)  # [m] of the arm at the end of the tick

    def _aim(self, tick: int) -> Value:
        """Return where the arm wants to be [m]; also note how far the hand closes until then."""
        time_s = tick * self.tick_s
        if self._closed != 1.0:  # else what follows stays as it is
            closed, closing = self._closing, self._task.closing(time_s)
            self._closed, self._closing = closed, closing
            self._squeeze = (self._half_squeeze * (closed + closing)) * self.axis
            self._facing = (self._face + self._gap * (1.0 - closing)) * self.axis
        return self._facing + self._task.offset(time_s, dof=self._dof)

    def _force(self, x: Value, xd: Value) -> Value:
        if not self._ticks:
            self.y = x  # it takes hold of the handle where that is
        # The grip force is held while the arm goes on by the implicit midpoint rule.
        tick_s, y, yd = self.tick_s, self.y, self.yd
        f_h = self._grip.force(y - x, yd - xd)
        before = self.target
        self.target = target = self._aim(self._ticks + 1)
        step, squeeze = target - before, self._squeeze
        lead = before + 0.5 * step - y
        stiffness, damping = self._stiffness, self._damping
        drive = stiffness * lead + damping * step / tick_s + squeeze - f_h
        moved, self.yd = arm_step(yd, drive, self._twice_mass, self._inertia, tick_s)
        pull = stiffness * (lead - 0.5 * moved) + damping * (step - moved) / tick_s
        self.effort_j = self.effort_j + dot(pull, step) + dot(squeeze, moved)
        self.y = y + moved
        return f_h


class RecordedHand(Operator):
    """An arm that moves as recorded, ``(ticks, dof)`` [m] from where the device is at first; grip
    spring and damper pull the handle along.

    The arm itself yields to nothing, so any energy it gives is the work of the recorded motion.
    """

    def __init__(self, params: OperatorParams, recording: Array, at: Setting) -> None:
        super().__init__(tick_s=at.tick_s, dof=at.dof)
        self._grip = Grip(params, arm_mass=np.inf, tick_s=at.tick_s)
        before, after = (-1, 0) if params.repeat else (0, -1)
        around = np.concatenate([[recording[before]], recording, [recording[after]]])
        self._y = rows_of(recording, at.dof)
        self._yd = rows_of((around[2:] - around[:-2]) / (2.0 * at.tick_s), at.dof)
        self._start = along_first_axis(at.start, at.dof)
        self._repeat = params.repeat

    def _force(self, x: Value, xd: Value) -> Value:
        row = self._ticks % len(self._y) if self._repeat else self._ticks
        if row >= len(self._y):
            return self._grip.force(self._start + self._y[-1] - x, -xd)
        return self._grip.force(self._start + self._y[row] - x, self._yd[row] - xd)


def arm_step(
    yd: Value, drive: Value, twice_mass: Value, inertia: Value, tick_s: float
) -> tuple[Value, Value]:
    """Return how far an arm moves in a tick [m], and its velocity afterwards [m/s].

    It has the velocity ``yd`` before [m/s]; ``drive`` is the force on it if it stayed where it is
    [N], ``inertia`` 2 m + T D + T^2 K/2 of its damper D and spring K [kg].
    """
    velocity = (twice_mass * yd + tick_s * drive) / inertia  # the mean of the tick
    return tick_s * velocity, 2.0 * velocity - yd
