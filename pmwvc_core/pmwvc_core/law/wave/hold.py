# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The hold: one packet expanded to the ticks of its frame (App. B, Eq. 43-54, indices corrected).

::

    v_m = v_{i-1} + (v_i - v_{i-1}) j/M      delayed first order, for the ticks j = 1..M after a
                                             packet; v_{-1} = 0
    v_m = v_i                                zero order (M = 1 here), and after M ticks

A start other than zero would be energy that was never sent. A packet that comes early starts its
ramp at the value reached, so the output never jumps. That is passive: with E = T_c (M-1)/4 v_m^2
stored at the instant of a packet, a frame of any number of ticks up to M gives out no more than
the packet brings and E loses. After M ticks the output stays until the next packet: this spends
energy that did not arrive; whoever owns the link watches the frames.

Equations: docs/theory.md 3.1, 3.4.
"""

from typing import NamedTuple

from pmwvc_core.law.vectors import Vector, each


class Hold(NamedTuple):
    """Ramp of the present frame [sqrt(W)], and the ticks of it that are over."""

    start: Vector
    target: Vector
    value: Vector
    done: int


def load(s: Hold, v: Vector) -> Hold:
    """Begin a frame with the packet v [sqrt(W)]."""
    return Hold(s.value, v, s.value, 0)


def hold(s: Hold, ticks: int) -> tuple[Hold, Vector]:
    """Return the wave of the next tick [sqrt(W)]; ``ticks`` is M, or 1 for zero order."""
    done = s.done + 1
    value = s.target
    if done < ticks:
        value = each(_between, (s.start, s.target), done / ticks)
    return Hold(s.start, s.target, value, done), value


def _between(start: float, target: float, ratio: float) -> float:
    return start + (target - start) * ratio
