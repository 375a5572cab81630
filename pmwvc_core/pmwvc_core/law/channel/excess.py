# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The free energy of a playout beside its needs. One without the energy for what is undelivered is
*short*; the other direction then passes on what it can spare.

Equations: docs/theory.md 17.19.
"""

from pmwvc_core.law.channel.playout import FEW, Playout, free_j
from pmwvc_core.law.vectors import length, squared

SPARED_J = 1e-4  # free energy below which a playout with something undelivered is short
PASSED_S = 0.1  # time constant with which an excess is passed on


def needed_j(s: Playout) -> float:
    """Return the free energy that makes up what is undelivered beside the present wave [J]."""
    return SPARED_J + length(s.undelivered) * length(s.concealed.wave)


def is_short(s: Playout) -> bool:
    """Tell whether something is undelivered, and there is less energy than that takes."""
    return squared(s.undelivered) > FEW**2 and free_j(s) < needed_j(s)


def release(s: Playout, most_j: float, beyond_j: float) -> tuple[Playout, float]:
    """Return free energy beyond a level, at most so much: the wave can do without it [J]."""
    released_j, m = max(min(free_j(s) - beyond_j, most_j), 0.0), s.moved
    if released_j == 0.0:
        return s, released_j
    return s._replace(moved=m._replace(released_j=m.released_j + released_j)), released_j


def spared(s: Playout, h: float, wanted: bool) -> tuple[Playout, float]:
    """Return the part of the free energy that passes on in h seconds, where it is wanted [J]; what
    is needed here stays.
    """
    if not wanted:
        return s, 0.0
    return release(s, max(free_j(s) - needed_j(s), 0.0) * min(h / PASSED_S, 1.0), 0.0)
