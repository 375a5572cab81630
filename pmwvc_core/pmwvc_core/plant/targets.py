# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Targets of a remote hand in simulation: from a table, or of somebody who does the task.

Between the rows of a table nothing comes: a gap of more than ``SILENT_S`` lets go, as a row that
is not finite does. The task is done with a pointer, a target every ``POINTER_S``: on the user's
face of the object, and ``squeeze / stiffness`` inside it once the hands have closed.
"""

from typing import NamedTuple

from pmwvc_core.law.vectors import Vector, minus, plus, scaled, zero
from pmwvc_core.numeric import Array, Integers
from pmwvc_core.plant.forces import hand_force, hand_hold, row
from pmwvc_core.plant.remote_hand import (
    RemoteHand,
    RemoteParams,
    remote_force,
    remote_hold,
    remote_target,
)
from pmwvc_core.plant.task import Task, closing, offset

POINTER_S = 0.016


class TableHand(NamedTuple):
    """A remote hand and its place in a table of targets."""

    hand: RemoteHand
    tick: int
    next: int  # row


class TableParams(NamedTuple):
    """A table of targets in the order of time.

    Ticks count from the moment of coupling; where it is early, from the start of the force loop.
    """

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


def _read(s: TableHand, p: TableParams) -> TableHand:
    """Take the targets of this tick."""
    hand, number = s.hand, s.next
    while number < len(p.ticks) and p.ticks[number] <= s.tick:
        hand = remote_target(hand, row(p.rows, number, p.axes))
        number += 1
    return TableHand(hand, s.tick + 1, number)


@hand_force.member(TableHand)
def _table(s: TableHand, x: Vector, xd: Vector, p: TableParams) -> tuple[TableHand, Vector]:
    s = _read(s, p)
    hand, f_h = remote_force(s.hand, x, xd, p.hand)
    return s._replace(hand=hand), f_h


@hand_hold.member(TableHand)
def _table_before(s: TableHand, x: Vector, p: TableParams) -> tuple[TableHand, Vector]:
    if not p.early:
        return s, zero(x)
    s = _read(s, p)
    hand, f_h = remote_hold(s.hand, x, p.hand)
    return s._replace(hand=hand), f_h


@hand_force.member(TaskHand)
def _task(s: TaskHand, x: Vector, xd: Vector, p: PointerParams) -> tuple[TaskHand, Vector]:
    hand, time_s = s.hand, s.tick * p.hand.tick_s
    closed = closing(time_s, p.task) if s.tick % p.every == 0 else 0.0
    if closed > 0.0:
        aim = plus(p.start, scaled(minus(p.pressed, p.start), closed))
        hand = remote_target(hand, plus(aim, offset(time_s, p.task)))
    hand, f_h = remote_force(hand, x, xd, p.hand)
    return TaskHand(hand, s.tick + 1), f_h
