# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The brake at the device: it holds the hand where it was while no waves come.

Without waves only b xd opposes a hand, which closes in by millimetres to centimetres; to push it
out again afterwards takes more energy than it gave. An elastic-plastic spring z beside the damper
gives what is missing of a force F_L (:mod:`pmwvc_core.wave.brake_force`)::

    z <- z + dx,   F = k z,   k = b/STALL_S
    z shortened to |k z| <= F_L, |f + k z| <= max(F_L, |f|)      f: asked for without it

It begins without force where the wait began, and z is only ever shortened, so with F held over a
tick, sum F dx + k |dx|^2/2 >= k |z|^2/2: what the sampling makes is less than the damper b takes
while k T <= 2 b, for loops that stall for up to 2 ``STALL_S``. It gives back what the hand put in,
never more.

Equations: docs/theory.md 17.12.
"""

from pmwvc_core.numeric import (
    LARGEST,
    Flag,
    Value,
    anywhere,
    limit_length,
    maximum,
    squared,
    where,
    within,
)
from pmwvc_core.params import MasterParams
from pmwvc_core.state import Stateful
from pmwvc_core.wave.affordable import affordable
from pmwvc_core.wave.brake_force import BrakeForce
from pmwvc_core.wave.impedance import impedance_of, smallest_of_runs

STALL_S = 0.0125
RETURN_S = 0.2


class HandBrake(Stateful):
    """See the module.

    Parameters
    ----------
    impedance
        Wave impedance b of the port, the smallest one of a matrix [N s/m].
    tick_s
        Period of the force loop [s].
    """

    BLOCKS = "_largest"
    MEMORY = "_x _z"

    def __init__(self, impedance: Value, *, tick_s: float) -> None:
        self._stiffness = impedance * (1.0 / STALL_S)
        self._largest = BrakeForce(step_s=tick_s, return_s=RETURN_S)
        self._x: Value = 0.0
        self._z: Value = 0.0  # deflection [m]

    @property
    def holds(self) -> Flag:
        """Whether there is a force that it may hold, one per run."""
        return self._largest.limit > 0.0

    @property
    def stored_j(self) -> Value:
        """Energy that the hand can have back [J]."""
        return 0.5 * self._stiffness * squared(self._z)

    def reset(self) -> None:
        """Let go at once: what is rendered next has nothing to do with what was."""
        self._largest.reset()
        self._z = 0.0 * self._z

    def step(self, waits: Flag, x: Value, f: Value) -> bool:
        """Go one tick on; tell whether nothing is held, in no run.

        Parameters
        ----------
        waits
            Whether no waves come.
        x
            Position [m], ``(..., dof)``; where it is no number nothing begins to be held.
        f
            Force on the device in the tick before [N].
        """
        before, self._x = self._x, x
        if self._largest.idle and (waits is False or not anywhere(waits)):
            self._largest.step(False, f)
            return True
        known = within(x, LARGEST)
        moved = where(known, x, 0.0) - where(within(before, LARGEST), before, 0.0)
        self._largest.step(waits & known, f)
        if self._largest.idle:
            self._z = 0.0 * moved
            return True
        self._z = limit_length(self._z + moved, self._largest.limit / self._stiffness)
        return False

    def force(self, f: Value) -> Value:
        """Return the brake's force beside a force ``f`` that the controller asks for [N]."""
        limit = self._largest.limit
        spare = maximum(limit * limit - squared(f), 0.0)
        given, _ = affordable(f, self._stiffness * self._z, spare)
        self._z = given / self._stiffness
        return given


def brake_of(params: MasterParams) -> HandBrake:
    """Return the brake of a master's port."""
    return HandBrake(smallest_of_runs(impedance_of(params)), tick_s=params.tick_s)
