# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""From the packet rate up to the tick rate: zero-order hold and delayed first-order hold.

A packet v_i stands for M ticks, so it brings the energy |v_i|^2 M T_c / 2. The rate drop on the
other way belongs to the anti-aliasing filter (:mod:`pmwvc_core.wave.filters`).

Equations: docs/theory.md 3.1.
"""

from pmwvc_core.numeric import Value
from pmwvc_core.state import Stateful


class Hold(Stateful):
    """Expand one packet to the ticks of its frame (App. B, Eq. 43-54, indices corrected).

    ``zoh``: v_m = v_i. ``foh``: v_m = v_{i-1} + (v_i - v_{i-1}) j/M for the ticks j = 1..M after
    the load, where v_{-1} = 0: a start value other than zero would be energy that was never sent.

    A packet that comes early starts its ramp at the value reached, so the output never jumps. That
    is passive: with E = T_c (M-1)/4 v_m^2 as the energy stored at the instant of a load, a frame
    of any number of ticks up to M gives out no more than the packet brings and E loses (for a
    whole frame this is the closed form of the equation).

    After M ticks the output stays at v_i until the next load. This hold-last spends energy that
    did not arrive: whoever owns the link has to watch the frames, not the hold.

    Parameters
    ----------
    ticks
        M, the number of ticks a packet stands for.
    """

    SIGNALS = "_start _target _value"
    MEMORY = "_done"
    __slots__ = ("_done", "_start", "_target", "_value", "ticks")

    def __init__(self, kind: str, *, ticks: int) -> None:
        if kind not in ("zoh", "foh"):
            raise ValueError(f"hold = {kind!r}: must be one of zoh, foh")
        self.ticks = ticks if kind == "foh" else 1  # a ramp of one tick is a zero-order hold
        self._start: Value = 0.0
        self._target: Value = 0.0
        self._value: Value = 0.0
        self._done = 0

    def load(self, v: Value) -> None:
        """Begin a frame with the packet v [sqrt(W)], float or ``(..., dof)``."""
        self._start = self._value
        self._target = v
        self._done = 0

    def step(self) -> Value:
        """Return the wave of the next tick [sqrt(W)]."""
        self._done = done = self._done + 1
        if done < self.ticks:
            ratio = done / self.ticks
            self._value = self._start + (self._target - self._start) * ratio
        else:
            self._value = self._target
        return self._value
