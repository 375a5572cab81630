# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Environments as black boxes (App. C), position and velocity in, force out: the calls of one, and
what it is made for.

Signals are arrays ``(users, dof)``. Forces act from the avatars on the environment. A user who is
not there stands still; its force is ignored.
"""

from dataclasses import dataclass
from typing import Any, Protocol

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
    """An environment as a black box: all that it must have, and here what it may have besides.

    ``join(user, position)``, ``leave(user)``
        Called before the next step when user 0, 1, ... joins with its avatar at ``(dof,)`` [m],
        or leaves.
    ``local(position, dt) -> (F0, G)``
        A slope of the force, with which the loop is solved without a model: F0 [N] and G [N s/m],
        each ``(users, dof)``; the next force is about F0 + G xd. ``position`` is where the
        avatars would be with xd = 0; xd moves them by ``dt`` xd (``dt`` is the period for
        backward Euler, half of it for the trapezoid, 0 for forward Euler). Nothing may move here:
        ``step`` follows. A negative slope counts as zero.
    ``energy``
        How much energy it holds [J], one number. The ledger keeps no more than that.
    ``position``, ``velocity``
        An object that traces and pictures show, ``(dof,)`` [m], [m/s].
    """

    def step(self, position: Array, velocity: Array, dt: float) -> Array:
        """Go one step on.

        Parameters
        ----------
        position, velocity
            Of the avatars at the end of the step, ``(users, dof)`` [m], [m/s]; not to be
            written to.
        dt
            Length of the step, always ``server.period_s`` [s].

        Returns
        -------
        Array
            Forces of the avatars on the environment, of the same shape [N].
        """
        ...
