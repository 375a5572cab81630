# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""From the packet rate up to the tick rate: zero-order hold and delayed first-order hold.

A packet v_i stands for M ticks, so it brings the energy |v_i|^2 M T_c / 2. The rate drop on the
other way belongs to the anti-aliasing filter (:mod:`pmwvc_core.wave.filters`).
"""

from pmwvc_core.numeric import Value


class Hold:
    """Expand one packet to the ticks of its frame (App. B, Eq. 43-54, indices corrected).

    ``zoh``: v_m = v_i. ``foh``: v_m = v_{i-1} + (v_i - v_{i-1}) j/M for the ticks j = 1..M after
    the load, where v_{-1} = 0: a start value other than zero would be energy that nobody sent.

    A ramp always starts at the value loaded before, also when it was cut short. Each tick is then
    a mean of v_{i-1} and v_i with weights 1 - j/M and j/M; over its two frames a packet is used
    with a total weight of at most (M+1)/2 + (M-1)/2 = M, and as the square is convex no more
    energy comes out than came in. Starting at the value reached instead would look smoother but
    uses the older packet longer than M ticks: not passive.

    After M ticks the output stays at v_i until the next load. This hold-last spends energy that
    did not arrive: the frame has to be watched by the owner, not here.

    Parameters
    ----------
    kind
        ``zoh`` or ``foh``.
    ticks
        M, the number of ticks a packet stands for.
    """

    __slots__ = ("_before", "_done", "_target", "ticks")

    def __init__(self, kind: str, *, ticks: int) -> None:
        if kind not in ("zoh", "foh"):
            raise ValueError(f"hold = {kind!r}: must be one of zoh, foh")
        self.ticks = ticks if kind == "foh" else 1  # a ramp of one tick is a zero-order hold
        self._before: Value = 0.0
        self._target: Value = 0.0
        self._done = self.ticks

    def load(self, v: Value) -> None:
        """Begin a frame with the packet v [sqrt(W)], float or ``(..., dof)``."""
        self._before = self._target
        self._target = v
        self._done = 0

    def step(self) -> Value:
        """Return the wave of the next tick [sqrt(W)]."""
        done = self._done + 1
        if done >= self.ticks:
            return self._target
        self._done = done
        return self._before + (self._target - self._before) * (done / self.ticks)
