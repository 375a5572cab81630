# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The linear model by an independent route: every block's equations, written out again as rows.

It shares with the program parameters, filter designs, the weights of the integrators and the exact
motion of a mass over a tick; no block that runs.
"""

from typing import NamedTuple

import numpy as np
from oracle.linear_model import rigid
from oracle.linear_model.loop import Loop


class Transitions(NamedTuple):
    """Transition matrices ``(runs, n, n)`` of scenarios of equal structure."""

    matrices: np.ndarray
    states: list[str]
    ticks: int
    rigid: list[rigid.Family]


def transitions(scenario, *, live=False, weights=()):
    """Return the transition matrices of a scenario whose numbers may be columns ``(runs, 1)``."""
    loop = Loop(scenario, live=live, weights=weights)
    rows, _ = loop.around(inputs=False)
    return Transitions(rows, loop.names, loop.ticks, rigid.families(loop))
