# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Velocities for which forces balance, where points press and rub: Newton's method.

::

    missing(x) = A x + g(x) - wanted + sum J^T phi(h J x) = 0

with g . x = 0. A part of Newton's step is taken that comes nearer, or the whole one where none
does: friction, bounded by mu F, has slopes of no potential. Where that does not settle (1 in 2000
steps, mu above 1), what presses in the best round bounds friction: forces then have a potential,
whose least value steps do not pass by far; then again, by turns.
"""

from collections.abc import Callable
from operator import attrgetter
from typing import NamedTuple

import numpy as np

from pmwvc_core.numeric import Array
from pmwvc_core.scenes.pressing import Pressed

ROUNDS, MOST_HALVINGS, TURNS = 30, 12, 24


class Trial(NamedTuple):
    """Velocities ``(k,)``, what is missing to balance ``(k,)`` and how much that is [W], its slope
    ``(k, k)`` where it is asked for, the points, and their rates by x, J ``(n, 3, k)``.
    """

    x: Array
    missing: Array
    missing_w: float
    slope: Callable[[], Array]
    after: Pressed
    by: Array


def balanced(
    tried: Callable[[Array, Array | None], Trial], start: Array, enough_w: float, friction: Array
) -> Trial:
    """Return the trial that balances, from ``tried(x, bound)``; friction is mu ``(n,)``.
    RuntimeError where none was found.
    """
    bound, trial = None, tried(start, None)
    best = trial
    for number in range(TURNS * ROUNDS):
        if trial.missing_w <= enough_w:
            return trial
        if number and number % ROUNDS == 0:
            bound = friction * best.after.pressing if bound is None else None
            trial = best = tried(best.x, bound)
        change = np.linalg.solve(trial.slope(), trial.missing)
        for part in (*0.5 ** np.arange(MOST_HALVINGS), 1.0):
            then = tried(trial.x - part * change, bound)
            beyond = then.missing @ change < -0.5 * (trial.missing @ change)
            if then.missing_w < trial.missing_w if bound is None else not beyond:
                break
        trial, best = then, min(best, then, key=attrgetter("missing_w"))
    raise RuntimeError("the contacts of the box did not come to balance")
