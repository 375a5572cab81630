# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The calls of an environment that is a black box to the port, and what one is made for.

Signals are arrays whose first axis is the user and whose last is the degree of freedom: ``(users,
dof)`` in a live session, ``(users, runs, dof)`` in a batch. Code that works elementwise over the
users works on both. Forces act from the avatars on the environment. A user who is not there stands
still; its force is ignored.
"""

from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

from pmwvc_core.numeric import Array
from pmwvc_core.params import ContactParams, ServerParams


@dataclass(frozen=True, slots=True)
class EnvironmentSetup:
    """The setup that an environment is made for; lists are in the order of the users."""

    dof: int
    period_s: float
    sides: tuple[int, ...]  # -1: left of the object, pushes towards +x; +1: right
    server: ServerParams
    contacts: tuple[ContactParams, ...]
    own: Any = None  # what the factory's attribute ``params`` declares

    @property
    def users(self) -> int:
        """Number of users."""
        return len(self.contacts)


class BlackBox(Protocol):
    """An environment as a black box: all that it must have. More that it may have stands below.

    It may also have ``join(user, position)`` and ``leave(user)``, called before the next step when
    user 0, 1, ... joins with its avatar at ``(..., dof)`` [m], or leaves.
    """

    def step(self, position: Array, velocity: Array, dt: float) -> Array:
        """Go one step on.

        Parameters
        ----------
        position, velocity
            Of the avatars at the end of the step, ``(users, ..., dof)`` [m], [m/s]; not to be
            written to.
        dt
            Length of the step, always ``server.period_s`` [s].

        Returns
        -------
        Array
            Forces of the avatars on the environment, of the same shape [N].
        """
        ...


@runtime_checkable
class Sloped(Protocol):
    """May be there: a slope of the force, with which the loop is solved without a model."""

    def local(self, position: Array, dt: float) -> tuple[Array, Array]:
        """Return F0 [N] and G [N s/m], each ``(users, ..., dof)``: the next force is about F0 + G
        xd.

        ``position`` is where the avatars would be with xd = 0; xd moves them by ``dt`` xd (``dt``
        is the period for backward Euler, half of it for the trapezoid, 0 for forward Euler).
        Nothing may move here: ``step`` follows. A negative slope counts as zero.
        """
        ...


@runtime_checkable
class Storing(Protocol):
    """May be there: how much energy it holds. The ledger keeps no more than that."""

    @property
    def energy(self) -> Array | float:
        """Energy stored [J]: one number, or ``(runs, 1)``."""
        ...


@runtime_checkable
class Shown(Protocol):
    """May be there: an object that traces and pictures show."""

    @property
    def position(self) -> Array | float:
        """Position of the object, ``(..., dof)`` [m]."""
        ...

    @property
    def velocity(self) -> Array | float:
        """Velocity of the object, ``(..., dof)`` [m/s]."""
        ...
