# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The hand of a recorded session as the force it exerted, tick for tick.

It does not react: where the replayed device meets another force than the recorded one did, nothing
brings it back to where the hand would have held it.
"""

from pmwvc_core.numeric import Array, Value
from pmwvc_core.plant.forces import Operator, rows_of


class ForceOnRecord(Operator):
    """A force with one row per tick of the session, ``(ticks, dof)`` [N]; none after its end.

    The recording knows itself when the hand began, so time passes from the first tick, coupled or
    not. Rows that are not numbers (not recorded) are no force.
    """

    def __init__(self, recording: Array, *, tick_s: float, dof: int) -> None:
        super().__init__(tick_s=tick_s, dof=dof)
        self._rows = rows_of(recording, dof)

    def hold(self) -> Value:
        """Return the recorded force of this tick [N]."""
        f_h = self._force(0.0, 0.0)
        self._ticks += 1
        return f_h

    def _force(self, x: Value, xd: Value) -> Value:
        return self._rows[self._ticks] if self._ticks < len(self._rows) else 0.0 * self.axis
