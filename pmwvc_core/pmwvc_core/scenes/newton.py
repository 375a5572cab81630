# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Velocities for which forces balance, where points press and rub: Newton's method.

::

    missing(x) = A x + g(x) - wanted + sum J^T phi(h J x) = 0

with g . x = 0. A part of Newton's step is taken that comes nearer, or the whole one where none
does: friction, bounded by mu F, has slopes of no potential. Where that does not settle (1 in 2000
steps, mu above 1), what presses in the best round bounds friction: forces then have a potential,
whose least value steps do not pass by far; then again, by turns. What no round mends is rounding.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from pmwvc_core.numeric import Array
from pmwvc_core.scenes.pressing import Pressed

SETTLED, NEAR = 1e-14, 1e-11  # of what is wanted: done, and done in one round more
ROUNDED_W, ROUNDS, MOST_HALVINGS, TURNS = 1e-18, 30, 12, 24  # the first: no round comes nearer


class Trial(NamedTuple):
    """Velocities ``(k,)``, what is missing to balance ``(k,)``, its slope ``(k, k)`` where it is
    asked for, the points, and the poses that the velocities lead to.
    """

    x: Array
    missing: Array
    slope: Callable[[], Array]
    after: Pressed
    poses: Any


def balanced(
    tried: Callable[[Array, Array | None], Trial], start: Array, resists: Array, wanted: Array,
    friction: Array,
) -> Trial:  # fmt: skip
    """Return the trial that balances, from ``tried(x, bound)``; ``resists`` is A's diagonal,
    ``(k,)``, mu ``(n,)``. RuntimeError where none was found.
    """

    def size(trial: Trial) -> float:
        return float(trial.missing @ (trial.missing / resists))

    whole, bound, trial = float(np.sum(wanted**2 / resists)), None, tried(start, None)
    best = trial
    for number in range(TURNS * ROUNDS):
        if size(trial) <= SETTLED**2 * whole:
            return trial
        if number and number % ROUNDS == 0:
            bound = friction * best.after.pressing if bound is None else None
            trial = best = tried(best.x, bound)
        change = np.linalg.solve(trial.slope(), trial.missing)
        near = size(trial) <= NEAR**2 * whole
        for part in (1.0,) if near else (*0.5 ** np.arange(MOST_HALVINGS), 1.0):
            then = tried(trial.x - part * change, bound)
            beyond = then.missing @ change < -0.5 * (trial.missing @ change)
            if size(then) < size(trial) if bound is None else not beyond:
                break
        if near or size(trial) <= min(ROUNDED_W, 2.0 * size(then)):
            return min(trial, then, key=size)
        trial, best = then, min(best, then, key=size)
    raise RuntimeError("the contacts of the box did not come to balance")
