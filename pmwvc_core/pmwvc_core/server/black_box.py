# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Environments as black boxes (App. C), position and velocity in, force out: what one is made for,
its calls, and one behind the port of :mod:`pmwvc_core.law.black_box`, contained: where it fails,
every port is a matched damper for that step.

Waiting is not decided here: a ``Call`` runs the exchange, at once in a simulation, in a thread of
its own in a live server, and raises ``Unanswered`` where it will not wait any longer. Equation of
an answer to an impedance: docs/theory.md 5.15.
"""

import json
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple, Protocol, TypeAlias

import numpy as np

from pmwvc_core.law.black_box import touched
from pmwvc_core.law.black_box.black_box import BlackBoxParams
from pmwvc_core.law.vectors import Vector, zero
from pmwvc_core.law.wave.wave import rooted
from pmwvc_core.numeric import Array
from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.plugins import BadAnswer, Faults, refused
from pmwvc_core.server.contained import LARGEST_N, signal
from pmwvc_core.server.turned import Turned

ROUNDING = 1e-12
Call: TypeAlias = Callable[[Callable[[], Any]], Any]


@dataclass(frozen=True, slots=True)
class EnvironmentSetup:
    """The setup that an environment is made for; lists are in the order of the users."""

    dof: int
    period_s: float
    sides: tuple[int, ...]  # -1: left of the object, pushes towards +x; +1: right
    server: ServerParams
    contacts: tuple[ContactParams, ...]
    own: Any = None  # what the factory's attribute ``params`` declares
    impedances: Sequence[Any] = ()  # of the users' ports, numbers or matrices [N s/m]

    @property
    def users(self) -> int:
        """Number of users."""
        return len(self.contacts)


class BlackBox(Protocol):
    """All that an environment must have, with forces that act from the avatars on it.

    ``meet(drive, impedance, dt) -> velocity``
        In place of ``step``: go on by ``dt`` [s] with the ports as part of the equations, which
        push with ``drive - impedance * velocity`` [N]. ``drive`` is ``(users, dof)`` [N],
        ``impedance`` ``(users,)`` [N s/m], or where matrices couple the axes, and for six axes on
        the strict channel, ``(users, dof, dof)``: for an environment with ``couples = True`` only.
        Return the mean velocities ``(users, dof)`` [m/s], by which the avatars move. Such a loop
        has no delay and no bound.

    Besides it may have:

    ``join(user, position)``, ``leave(user)``
        Called before the next step when user 0, 1, ... joins with its avatar at ``(dof,)`` [m],
        or leaves. A user who is not there stands still; its force is ignored.
    ``local(position, dt) -> (F0, G)``
        A slope of the force, with which the loop is solved: F0 [N] and G [N s/m], each
        ``(users, dof)``; the next force is about F0 + G xd. ``position`` is where the avatars
        would be with xd = 0; xd moves them by ``dt`` xd. Nothing may move here: ``step`` follows.
        A negative slope counts as zero.
    ``energy``
        How much energy it holds [J], one number. The ledger keeps no more than that.
    ``turned``
        With ``meet`` and six axes: how the handles are turned, unit quaternions x y z w, world
        axes ``(users, 4)``. Their drift from the devices is repaid.
    ``position``, ``velocity``
        An object that traces and pictures show, ``(dof,)`` [m], [m/s].
    """

    def step(self, position: Array, velocity: Array, dt: float) -> Array:
        """Go one step on of ``dt``, always ``server.period_s`` [s]; return the forces of the
        avatars on it ``(users, dof)`` [N]. ``position`` and ``velocity`` are those of the avatars
        at the end of the step, of the same shape [m], [m/s]; not to be written to.
        """
        ...


class Outside(NamedTuple):
    """An environment, the calls that are still to be passed on to it (added by the port's thread,
    made perhaps by another one), how it is asked, what went wrong, who is there, and where avatars
    are that it moves itself, also by answers that come too late ``(users, dof)`` [m], or turns.
    """

    environment: BlackBox
    pending: deque[Callable[[], Any]]
    call: Call
    faults: Faults
    there: tuple[bool, ...]
    places: Array
    turned: Turned


def matrices_of(impedance: Array, dof: int) -> Array:
    """Return impedances of ports, numbers or matrices, as ``(users, dof, dof)`` [N s/m]."""
    return impedance if impedance.ndim == 3 else impedance[:, None, None] * np.eye(dof)


def times_rows(matrices: Array, rows: Array) -> Array:
    """Return every user's matrix ``(users, n, n)`` times its row ``(users, n)``."""
    return np.asarray((matrices @ rows[:, :, np.newaxis])[:, :, 0])


@touched.visited.member(Outside)
def _visited(
    s: Outside, there: tuple[bool, ...], begins: tuple[bool, ...], positions: touched.Vectors
) -> Outside:
    for user, was in enumerate(s.there):
        if was and (begins[user] or not there[user]) and hasattr(s.environment, "leave"):
            s.pending.append(partial(s.environment.leave, user))
        if begins[user]:
            s.pending.append(partial(s.places.__setitem__, user, positions[user]))
            if hasattr(s.environment, "join"):
                s.pending.append(partial(s.environment.join, user, np.array(positions[user])))
            s.pending.append(partial(s.turned.since.pop, user, None))
            s.pending.append(partial(s.turned.look, s.environment))
    return s._replace(there=there)


def _answer(
    s: Outside, avatars: touched.Avatars, start: Array, velocity: Array, p: BlackBoxParams
) -> tuple[touched.Reply, Iterable[bool]]:
    """Pass joins and leaves on, solve the loop with the local slope if there is one, and step;
    return the checked answer, and for which users the force cannot be used. ``start`` is where the
    avatars are without their new velocity [m], ``velocity`` that without a slope [m/s], each
    ``(users, dof)``.
    """
    while s.pending:
        s.pending.popleft()()
    environment, h = s.environment, p.body.period_s
    if hasattr(environment, "meet"):
        drive = np.array([rooted(a.impedance, a.u) for a in avatars])
        impedance = np.array([a.impedance.b for a in avatars])
        b = matrices_of(impedance, start.shape[1])
        more = s.turned.repaying(s.places, s.there, h)
        drive += times_rows(b, more)
        velocity = signal(environment.meet(drive, impedance, h), start.shape, "meet")
        force = drive - times_rows(b, velocity)
        force[np.abs(force) < ROUNDING * np.abs(drive)] = 0.0
        s.places[:] += h * (np.nan_to_num(velocity) - more)
        s.turned.look(environment)
        return _replied(environment, avatars, velocity, s.places, force, True)
    if hasattr(environment, "local"):
        line = np.broadcast_arrays(start, *environment.local(start, p.new_s))[1:]
        force, slope = (signal(each, start.shape, "local") for each in line)
        if not np.isfinite(force + slope).all():
            raise BadAnswer("returned a slope from local that is not finite")
        rows = zip(avatars, rows_of(force), rows_of(np.maximum(slope, 0.0)), strict=True)
        velocity = np.array([touched.solved_line(a, f, g, p.identity) for a, f, g in rows])
    position = start + p.new_s * velocity
    position.flags.writeable = velocity.flags.writeable = False
    force = signal(environment.step(position, velocity, h), start.shape)
    return _replied(environment, avatars, velocity, position, force, False)


def _replied(
    environment: BlackBox, avatars: touched.Avatars, velocity: Array, end: Array, force: Array,
    solved: bool,
) -> tuple[touched.Reply, Iterable[bool]]:  # fmt: skip
    good = np.all(np.abs(force) <= LARGEST_N, axis=-1, keepdims=True)  # false for NaN
    rows = zip(avatars, rows_of(velocity), rows_of(np.where(good, force, np.nan)), strict=True)
    moved = tuple(a._replace(xd=xd, f=f) for a, xd, f in rows)
    stored_j, (x, xd) = _stored_j(environment), _shown(environment, force.shape[1:])
    return touched.Reply(True, moved, rows_of(end), stored_j, x, xd, solved), ~good[:, 0]


@touched.exchange.member(Outside)
def _exchange(
    s: Outside, visitors: touched.Visitors, velocities: touched.Vectors, p: BlackBoxParams
) -> tuple[Outside, touched.Reply]:
    avatars, _, starts = visitors
    ask = partial(_answer, s, avatars, np.array(starts), np.array(velocities), p)
    rest = zero(starts[0])
    damper = touched.Reply(False, avatars, starts, -1.0, rest, rest, False)
    reply, bad = s.faults.guarded(partial(s.call, ask), (damper, ()))
    s.faults.note_users(bad, "no usable force (not finite, or beyond 1e6 N)")
    return s, reply


@touched.touches.member(Outside)
def _touched(s: Outside, user: int, pushed: bool) -> bool:
    known = getattr(s.environment, "touching", ())
    return bool(known[user]) if user < len(known) else pushed


def _of_outside(box: Any, name: str, nothing: Any) -> Any:
    asked = getattr(box, "environment", None)
    return getattr(asked.environment, name, nothing) if isinstance(asked, Outside) else nothing


def shown_by(box: Any) -> tuple[Mapping[str, Sequence[float]], Sequence[float]]:
    """Return the bodies that an environment shows: x y z [m] and quaternion w x y z, by name; and
    contacts, 8 numbers each: indices of two bodies (-1: a fixed one), x y z [m], force on the
    second [N].
    """
    return dict(_of_outside(box, "poses", {})), list(_of_outside(box, "contacts", ()))


def description_of(box: Any) -> dict[str, Any]:
    """Return what is constant in an environment, as read from JSON; {}: nothing."""
    with refused("the description of server.environment", cannot_be="recorded"):
        return dict(json.loads(json.dumps(_of_outside(box, "description", {}), allow_nan=False)))


def rows_of(values: Array) -> touched.Vectors:
    """Return an array ``(rows, columns)`` as the laws have it."""
    return tuple(map(tuple, values.tolist()))


def _stored_j(environment: BlackBox) -> float:
    """Return the energy in the environment [J]; below zero where it reports none."""
    if not hasattr(environment, "energy"):
        return -1.0
    energy = np.asarray(environment.energy, dtype=float)
    if not np.isfinite(energy).all():
        raise BadAnswer(f"gave energy = {energy}: must be finite")
    return float(np.maximum(energy, 0.0).item())


def _shown(environment: BlackBox, shape: tuple[int, ...]) -> tuple[Vector, Vector]:
    """Return position [m] and velocity [m/s] of the object, zero where it shows none."""
    found = (getattr(environment, name, 0.0) for name in ("position", "velocity"))
    try:
        position, velocity = (np.array(np.broadcast_to(each, shape), float) for each in found)
    except (TypeError, ValueError):
        raise BadAnswer(f"shows its object otherwise than by an array {shape}") from None
    if not np.isfinite(position + velocity).all():
        raise BadAnswer(f"shows its object at {position}: must be finite")
    return tuple(position.tolist()), tuple(velocity.tolist())
