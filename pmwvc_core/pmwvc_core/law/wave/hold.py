# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The hold: one packet expanded to the ticks of its frame (App. B, Eq. 43-54, indices corrected).

::

    v_m = v_{i-1} + (v_i - v_{i-1}) j/M      delayed first order, for the ticks j = 1..M after a
                                             packet; v_{-1} = 0
    v_m = v_i                                zero order (M = 1 here), and after M ticks

An early packet starts its ramp at the value reached. With E = T_c (M-1)/4 v_m^2 stored, a frame of
up to M ticks releases no more than the packet brings and E loses; after M ticks it does.

Equations: docs/theory.md 3.1, 3.4.
"""

from typing import NamedTuple

from pmwvc_core.law.vectors import Vector, between


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
        value = between(s.start, s.target, done / ticks)
    return s._replace(value=value, done=done), value
