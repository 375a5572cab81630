# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The hand whose target comes from outside: a person with a pointer, a table, another program.

Arm and grip are those of :mod:`.hand`. The arm follows a point x_t that moves towards the newest
target with at most ``speed_m_s``, at most ``reach_n / stiffness`` from the arm::

    f_h = g [K (y - x) + B (yd - xd)] - (1 - g) brake xd
    m ydd = a k (x_t - y) - d yd - g [K (y - x) + B (yd - xd)]

A target that is not finite, or none for ``SILENT_S``, lets go: g and a fall to zero within
``FADE_S`` while x_t rests. The next one takes hold: the arm begins at the handle and g rises
within ``TAKE_S``, with K g (y - x)^2/2 constant. The sum S of :mod:`.hand` has the terms - g (B +
K T/2) T w^2/4 - (1 - g) brake T xd^2/4 here; their change with g is part of ``effort_j``.
Simulated targets come from a table, or from who does the task with a pointer, one every
``POINTER_S``.
"""

import math
from typing import NamedTuple

from pmwvc_core.law.vectors import (
    Vector,
    columns,
    dot,
    each,
    minus,
    plus,
    row,
    scaled,
    shortened,
    squared,
    within,
    zero,
)
from pmwvc_core.numeric import Array, Integers
from pmwvc_core.params import OperatorParams
from pmwvc_core.plant.forces import Task, closing, hand_force, offset
from pmwvc_core.plant.hand import Arm, Grip, arm_step, grip_force, grip_of

SILENT_S = 0.15
FADE_S = 0.1
TAKE_S = 0.03
FARTHEST_M = 10.0  # targets beyond are taken to be there
POINTER_S = 0.016


class RemoteHand(NamedTuple):
    """A hand and who drives it. While the handle is free, the arm is where that is."""

    y: Vector  # [m] of the arm
    yd: Vector  # [m/s]
    target: Vector  # [m] that it follows
    wanted: Vector  # [m] the newest target
    usable: bool  # it is finite, and not too old
    age: int  # ticks since it came
    holding: bool  # whether somebody holds the handle
    grip: float  # g
    pull: float  # a
    effort_j: float  # of the moving target and of the changes of grip


class RemoteParams(NamedTuple):
    """Arm and grip of a remote hand over a tick."""

    grip: Grip
    stiffness: float  # k
    brake: float
    twice_mass: float
    resistance: float  # 2 m + T d
    step_m: float  # farthest way of the arm's target in a tick
    reach_m: float  # from the arm to its target
    silent_ticks: int
    rise: float  # of g in a tick
    fall: float
    tick_s: float


def remote_params(params: OperatorParams, tick_s: float) -> RemoteParams:
    """Return the parameters of a remote hand."""
    arm = params.remote
    return RemoteParams(
        grip_of(params, arm.mass, tick_s), arm.stiffness, arm.brake, 2.0 * arm.mass,
        2.0 * arm.mass + tick_s * arm.damping, arm.speed_m_s * tick_s,
        arm.reach_n / arm.stiffness, round(SILENT_S / tick_s), tick_s / TAKE_S, tick_s / FADE_S,
        tick_s,
    )  # fmt: skip


def resting_remote(start: Vector) -> RemoteHand:
    """Return a hand that nobody drives, with its handle there [m]."""
    rest = zero(start)
    return RemoteHand(start, rest, start, rest, False, 0, False, 0.0, 0.0, 0.0)


def remote_target(s: RemoteHand, target: Vector) -> RemoteHand:
    """Take a target of this tick [m], before the hand moves; one that is not finite lets go."""
    usable = within(target, math.inf)
    return s._replace(wanted=target, usable=usable, age=-1, holding=s.holding and usable)


@hand_force.member(RemoteHand)
def remote_force(
    s: RemoteHand, x: Vector, xd: Vector, acts: bool, p: RemoteParams
) -> tuple[RemoteHand, Vector]:
    """Move the arm; return the force on the handle [N], none while not coupled."""
    age = s.age + 1
    s = s._replace(usable=s.usable and age <= p.silent_ticks, age=age)
    if not acts:
        return s, zero(x)
    s = _changed_grip(s, x, xd, p)
    if s.grip == 0.0 and s.pull == 0.0:
        return s._replace(y=x, yd=zero(x), target=x), scaled(xd, -p.brake)
    pull = scaled(grip_force(minus(s.y, x), minus(s.yd, xd), p.grip), s.grip)
    return _moved_arm(s, pull, p), minus(pull, scaled(xd, (1.0 - s.grip) * p.brake))


def _changed_grip(s: RemoteHand, x: Vector, xd: Vector, p: RemoteParams) -> RemoteHand:
    """Close or open the hand by a tick's part."""
    holding, grip, pull, y, target = s.holding and s.usable, s.grip, s.pull, s.y, s.target
    if s.usable and grip == 0.0 and pull == 0.0:
        holding, pull = True, 1.0
    if holding:
        grip = min(1.0, grip + p.rise)
        closer = scaled(minus(x, y), 1.0 - math.sqrt(s.grip / grip))
        y, target = plus(y, closer), plus(target, closer)
    else:
        grip, pull = max(0.0, grip - p.fall), max(0.0, pull - p.fall)
    effort_j = s.effort_j
    if grip != s.grip:
        power = p.grip.rate * squared(minus(s.yd, xd)) - p.brake * squared(xd)
        effort_j += 0.25 * p.tick_s * (s.grip - grip) * power
    return s._replace(y=y, target=target, holding=holding, grip=grip, pull=pull, effort_j=effort_j)


def _moved_arm(s: RemoteHand, pull: Vector, p: RemoteParams) -> RemoteHand:
    """Advance the arm by the implicit midpoint rule, the grip's pull held."""
    target = s.target
    if s.holding:
        wanted = shortened(s.wanted, FARTHEST_M)
        ahead = plus(target, shortened(minus(wanted, target), p.step_m))
        target = plus(s.y, shortened(minus(ahead, s.y), p.reach_m))
    stiffness = s.pull * p.stiffness
    inertia = p.resistance + 0.5 * p.tick_s**2 * stiffness
    spring = Arm(stiffness, 0.0, p.twice_mass, inertia, p.tick_s)
    rows = each(arm_step, (s.y, s.yd, s.target, target, scaled(pull, -1.0)), spring)
    moved, yd, drawn = columns(rows)
    effort_j = s.effort_j + dot(drawn, minus(target, s.target))
    return s._replace(y=plus(s.y, moved), yd=yd, target=target, effort_j=effort_j)


class TableHand(NamedTuple):
    """A remote hand and its place in a table of targets."""

    hand: RemoteHand
    tick: int
    next: int  # row


class TableParams(NamedTuple):
    """Targets in the order of time, from coupling on; if early, from the loop's start."""

    hand: RemoteParams
    ticks: Integers  # at which the rows come
    rows: Array  # (rows, axes) [m]
    axes: tuple[int, ...]  # numbers of the axes: 0, 1 ...
    early: bool


class TaskHand(NamedTuple):
    """A remote hand that does the task."""

    hand: RemoteHand
    tick: int


class PointerParams(NamedTuple):
    """The task as somebody does it with a pointer."""

    hand: RemoteParams
    task: Task
    start: Vector  # [m]
    pressed: Vector  # [m] where the hand goes as it closes
    every: int  # ticks


@hand_force.member(TableHand)
def _table(
    s: TableHand, x: Vector, xd: Vector, acts: bool, p: TableParams
) -> tuple[TableHand, Vector]:
    if not acts and not p.early:
        return s, zero(x)
    hand, number = s.hand, s.next
    while number < len(p.ticks) and p.ticks[number] <= s.tick:
        hand = remote_target(hand, row(number, p.rows, p.axes))
        number += 1
    hand, f_h = remote_force(hand, x, xd, acts, p.hand)
    return TableHand(hand, s.tick + 1, number), f_h


@hand_force.member(TaskHand)
def _task(
    s: TaskHand, x: Vector, xd: Vector, acts: bool, p: PointerParams
) -> tuple[TaskHand, Vector]:
    if not acts:
        return s, zero(x)
    hand, time_s = s.hand, s.tick * p.hand.tick_s
    closed = closing(time_s, p.task) if s.tick % p.every == 0 else 0.0
    if closed > 0.0:
        aim = plus(p.start, scaled(minus(p.pressed, p.start), closed))
        hand = remote_target(hand, plus(aim, offset(time_s, p.task)))
    hand, f_h = remote_force(hand, x, xd, acts, p.hand)
    return TaskHand(hand, s.tick + 1), f_h
