# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The five-parameter hand: an arm that wants to be somewhere, and a grip that joins it to the
handle; and an arm that moves as recorded.

The arm (mass m, position y) is drawn to its target x_t by stiffness k and damping d; the grip
(stiffness K, damping B) joins it to the handle (position x)::

    f_h = K (y - x) + B (yd - xd)
    m ydd = k (x_t - y) + d (xd_t - yd) + f_squeeze - f_h

Passive as sampled: the grip force is held over a tick T and formed half a tick ahead, f_h = K e +
(B + K T/2) w with e = y - x, w = yd - xd. With beta = B + K T/2 the sum

    S = kinetic energies + K e^2/2 - (beta T/4) w^2

changes in a tick by -B T ((w + w+)/2)^2 and the work from outside. S is positive while beta T/2 is
less than the reduced mass of arm and device, checked for ``LIGHTEST_DEVICE``. The arm goes by the
implicit midpoint rule; the work of target and squeezing force is ``effort_j``.
"""

import math
from typing import NamedTuple

import numpy as np

from pmwvc_core.errors import ParameterError
from pmwvc_core.law.vectors import Vector, columns, dot, each, minus, plus, row, scaled, zero
from pmwvc_core.numeric import Array
from pmwvc_core.params import OperatorParams, TaskParams
from pmwvc_core.plant.forces import Task, closing, hand_force, offset, rows_of, task_of

LIGHTEST_DEVICE = 0.05  # [kg]


class Place(NamedTuple):
    """Place and side of a hand, and the rate at which it acts."""

    side: int  # -1: left of the object, pushing towards +x; +1: right of it
    half_width_m: float  # half the object's width
    start_m: float  # where the device is at first, along axis 0
    tick_s: float  # period of the force loop
    axes: int  # of which axis 0 carries the task

    @property
    def start(self) -> Vector:
        """Where the device is at first [m]."""
        return self.along(self.start_m)

    def along(self, value: float) -> Vector:
        """Return a vector along axis 0."""
        return (value, *(0.0,) * (self.axes - 1))


class Grip(NamedTuple):
    """The spring and damper between arm and handle, its force held over a tick."""

    stiffness: float  # K [N/m]
    rate: float  # B + K T/2 [N s/m]


def grip_of(params: OperatorParams, arm_mass: float, tick_s: float) -> Grip:
    """Return the grip of an arm [kg]; ParameterError where it would not be stable."""
    rate = params.grip_damping + 0.5 * tick_s * params.grip_stiffness
    limit = 2.0 / (1.0 / LIGHTEST_DEVICE + 1.0 / arm_mass) / tick_s
    if rate >= limit:
        raise ParameterError(
            f"operator.grip_damping + grip_stiffness * tick_s / 2 = {rate:.4g} N s/m: must be < "
            f"{limit:.4g} N s/m for a hand that is stable on a device of {LIGHTEST_DEVICE} kg; "
            "make the grip softer or the tick shorter"
        )
    return Grip(params.grip_stiffness, rate)


def grip_force(lead: Vector, rate: Vector, p: Grip) -> Vector:
    """Return the force on the handle [N]; the arm leads it by [m], and at a rate of [m/s]."""
    return plus(scaled(lead, p.stiffness), scaled(rate, p.rate))


class Arm(NamedTuple):
    """The arm and its spring over a tick."""

    stiffness: float  # k
    rate: float  # d/T where the damper follows the target
    twice_mass: float
    inertia: float  # 2 m + T d + T^2 k/2
    tick_s: float


def arm_step(
    y: float, yd: float, before: float, target: float, force: float, p: Arm
) -> tuple[float, float, float]:
    """Return way [m] and end velocity [m/s] of the arm in a tick, and the target's pull [N]."""
    step = target - before
    lead = before + 0.5 * step - y
    drive = p.stiffness * lead + p.rate * step + force
    velocity = (p.twice_mass * yd + p.tick_s * drive) / p.inertia  # the mean of the tick
    moved = p.tick_s * velocity
    pull = p.stiffness * (lead - 0.5 * moved) + p.rate * (step - moved)
    return moved, 2.0 * velocity - yd, pull


class Hand(NamedTuple):
    """The five-parameter hand that carries out a task."""

    y: Vector  # [m] of the arm
    yd: Vector  # [m/s]
    target: Vector  # [m] of the arm at the end of the tick
    closed: float  # ratio
    ticks: int
    effort_j: float  # of the moving target and of the squeezing force


class HandParams(NamedTuple):
    """Arm, grip and task of a hand that starts at the device and closes the gap."""

    task: Task
    grip: Grip
    face: Vector  # [m] of the object
    gap: Vector  # [m] from there to the device at first
    half_squeeze: Vector  # [N]
    arm: Arm


def task_hand(params: OperatorParams, task: TaskParams, at: Place) -> tuple[Hand, HandParams]:
    """Return a hand at the beginning of its time; ParameterError where it would not be stable."""
    grip = grip_of(params, params.mass, at.tick_s)
    face = at.side * at.half_width_m
    # The arm's spring takes k/K of it back when the grip gives way: press that much harder.
    firm = max(params.grip_stiffness, params.stiffness)
    give = params.stiffness / firm if firm > 0.0 else 0.0
    half_squeeze = 0.5 * (-at.side * params.squeeze * (1.0 + give))
    inertia = (
        2.0 * params.mass + at.tick_s * params.damping + 0.5 * at.tick_s**2 * params.stiffness
    )
    arm = Arm(params.stiffness, params.damping / at.tick_s, 2.0 * params.mass, inertia, at.tick_s)
    start, rest = at.along(at.start_m), at.along(0.0)
    p = HandParams(
        task_of(task, at.axes), grip, at.along(face), at.along(at.start_m - face),
        at.along(half_squeeze), arm,
    )  # fmt: skip
    closed = closing(0.0, p.task)
    return Hand(start, rest, _aim(0, closed, p), closed, 0, 0.0), p


def _aim(tick: int, closed: float, p: HandParams) -> Vector:
    """Return where the arm wants to be [m]."""
    facing = plus(p.face, scaled(p.gap, 1.0 - closed))
    return plus(facing, offset(tick * p.arm.tick_s, p.task))


@hand_force.member(Hand)
def _held(s: Hand, x: Vector, xd: Vector, acts: bool, p: HandParams) -> tuple[Hand, Vector]:
    if not acts:
        return s, zero(x)
    y, ticks, closed = s.y, s.ticks + 1, s.closed
    if s.ticks == 0:
        y = x  # it takes hold of the handle where that is
    f_h = grip_force(minus(y, x), minus(s.yd, xd), p.grip)
    if closed != 1.0:
        closed = closing(ticks * p.arm.tick_s, p.task)
    target = _aim(ticks, closed, p)
    squeeze = scaled(p.half_squeeze, s.closed + closed)
    rows = each(arm_step, (y, s.yd, s.target, target, minus(squeeze, f_h)), p.arm)
    moved, yd, pull = columns(rows)
    effort_j = s.effort_j + dot(pull, minus(target, s.target)) + dot(squeeze, moved)
    return Hand(plus(y, moved), yd, target, closed, ticks, effort_j), f_h


class RecordedHand(NamedTuple):
    """An arm that moves as recorded and yields to nothing; its grip pulls the handle."""

    ticks: int


class RecordedMotion(NamedTuple):
    """A recorded motion, a row per tick, and the grip."""

    y: Array  # (ticks, axes) [m] from where the device is at first
    yd: Array  # (ticks, axes) [m/s]
    axes: tuple[int, ...]  # numbers of the axes: 0, 1 ...
    start: Vector  # [m]
    grip: Grip
    repeat: bool  # else the arm stays at its end


def recorded_motion(
    params: OperatorParams, recording: Array, start: Vector, tick_s: float
) -> RecordedMotion:
    """Return the parameters of a hand with a recording ``(ticks, 1 or axes)`` [m]."""
    before, after = (-1, 0) if params.repeat else (0, -1)
    around = np.concatenate([[recording[before]], recording, [recording[after]]])
    axes = len(start)
    y, yd = rows_of(recording, axes), rows_of((around[2:] - around[:-2]) / (2.0 * tick_s), axes)
    grip = grip_of(params, math.inf, tick_s)
    return RecordedMotion(y, yd, tuple(range(axes)), start, grip, params.repeat)


@hand_force.member(RecordedHand)
def _recorded(
    s: RecordedHand, x: Vector, xd: Vector, acts: bool, p: RecordedMotion
) -> tuple[RecordedHand, Vector]:
    if not acts:
        return s, zero(x)
    number, last = s.ticks, len(p.y) - 1
    if p.repeat:
        number = number % len(p.y)
    y = plus(p.start, row(min(number, last), p.y, p.axes))
    yd = row(number, p.yd, p.axes) if number <= last else zero(x)
    return RecordedHand(s.ticks + 1), grip_force(minus(y, x), minus(yd, xd), p.grip)
