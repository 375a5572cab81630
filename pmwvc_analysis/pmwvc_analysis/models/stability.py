# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Stability from the exact model: spectral radius and largest stiffness.

The largest stiffness is the first crossing: everything below it is stable. Where it becomes stable
again above, these islands are reported, too.

A question may cost some 4 s on one core, counted from sizes alone (ticks, states, runs) before it
is done: so an answer never depends on how busy a machine is. What costs more is "not known".
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from pmwvc_analysis.models.linear import axes_of, require_linear
from pmwvc_analysis.models.linearize import Linear, stable
from pmwvc_analysis.models.links import hyperperiod_ticks
from pmwvc_analysis.models.loop import loop_of
from pmwvc_analysis.models.variation import with_stiffness
from pmwvc_core.errors import PmwvcError
from pmwvc_core.numeric import Array, Flags
from pmwvc_core.scenario.scenario import Scenario

BOUND = 1e6  # [N/m] no contact stiffness above this is looked at
LOWEST = 0.1  # [N/m]
LARGEST_BATCH = 512
ALLOWED = 4e9  # work of a question, about nanoseconds, as measured on one core of 2024
TICK = 4e4  # of one user in one tick, from one state
STATES = 12  # of a user at either end, before they are counted
EIGENVALUES = 10.0  # of a matrix, per n^3
EVALUATIONS, PER_DECADE = 200, 10  # of a search for the largest stiffness; points of its grid


class UnknownError(PmwvcError, ValueError):
    """A question needs more work than it may."""


class StabilityLimit(NamedTuple):
    """The limit of stability along one parameter.

    ``first`` is where stability is lost: 0: the lowest value is unstable, None: none up to
    ``bound`` is.
    """

    first: float | None
    bound: float
    islands: list[tuple[float, float]]  # stable ranges above
    unknown: str = ""  # why it is not known

    @property
    def text(self) -> str:
        """The limit in words."""
        if self.unknown:
            return f"largest stable contact stiffness: {self.unknown}"
        if self.first is None:
            return f"stable at every contact stiffness up to {self.bound:,.0f} N/m"
        if self.first == 0.0:
            return "unstable at every contact stiffness"
        return f"largest stable contact stiffness: {self.first:.1f} N/m"


def radii(*runs: Scenario, live: bool = False) -> Array:
    """Return the spectral radii ``(runs,)`` over the hyperperiod of scenarios that differ in what
    is :func:`.stackable`; UnknownError where that is more work than allowed.
    """
    for run in runs[1:]:  # the first one is looked at by each loop
        require_linear(run)
    return model_of(*runs, live=live).radii()


def model_of(*runs: Scenario, live: bool = False, evaluations: int = 1) -> Linear:
    """Return the model of scenarios; UnknownError where so many of it are too much work."""
    require_linear(runs[0])
    _require_little(runs[0], evaluations)
    loop = loop_of(*runs, live=live)
    _require_little(runs[0], evaluations, len(loop.states) + int(loop.delays.sum()))
    return Linear(loop)


def _require_little(scenario: Scenario, evaluations: int, states: int = 0) -> None:
    """Raise UnknownError where stepping the users once and the server for every evaluation around
    their hyperperiod, from every state and packet, and eigenvalues are more work than allowed.
    """
    ticks, users = hyperperiod_ticks(scenario), scenario.users
    columns = sum(STATES + 2 * ticks // user.master.rate_drop for user in users)
    steps = ticks + evaluations * len(users) * ticks // scenario.period_ticks
    work = TICK * columns * axes_of(scenario) * steps
    if work + evaluations * EIGENVALUES * states**3 > ALLOWED:
        sizes = [f"a hyperperiod of {ticks} ticks", f"{states} states" if states else ""]
        raise UnknownError(
            f"{scenario.name}: not known: {', '.join(filter(None, sizes))}: too much work for the "
            "exact model; equal master.rate_drop and server.period_s (or common factors) and "
            "shorter delays need less, 'pmwvc simulate' needs none"
        )


def k_max(scenario: Scenario, *, live: bool = False, bound: float = BOUND) -> StabilityLimit:
    """Return the largest contact stiffness [N/m], all in proportion; unknown: too much work."""

    def at(stiffness: Array) -> Flags:
        """Tell where the loop is stable."""
        stiff = (with_stiffness(scenario, each) for each in stiffness)
        return np.asarray(stable(model_of(*stiff, live=live).radii()))

    try:
        model_of(with_stiffness(scenario, bound), live=live, evaluations=EVALUATIONS)
    except UnknownError as error:
        return StabilityLimit(None, bound, [], str(error))
    points = 1 + int(np.ceil(np.log10(bound / LOWEST) * PER_DECADE))
    changes = crossings(at, np.geomspace(LOWEST, bound, points))
    values = [*(value for value, _ in changes), bound]
    islands = list(zip(values[1::2], values[2::2], strict=False))
    return StabilityLimit(values[0] if changes else None, bound, islands)


def crossings(
    at: Callable[[Array], Flags], grid: Array, *, within: float = 1e-6, parts: int = 9
) -> list[tuple[float, bool]]:
    """Return where stability changes on an ascending grid, ``within`` a relative precision, and
    whether it is regained there; 0 where the lowest value is unstable. ``at`` tells which of
    several values are stable; an interval is divided into so many ``parts`` at a time.
    """
    batches = range(0, len(grid), LARGEST_BATCH)
    flags = np.concatenate([at(grid[i : i + LARGEST_BATCH]) for i in batches])
    found = [] if flags[0] else [(0.0, False)]
    for index in np.flatnonzero(flags[1:] != flags[:-1]):
        low, high, begins = float(grid[index]), float(grid[index + 1]), bool(flags[index])
        while high - low > within * max(abs(high), abs(low)):
            inner = np.linspace(low, high, parts + 1)[1:-1]
            same = at(inner) == begins
            step = len(same) if same.all() else int(np.argmin(same))
            ends = [low, *inner.tolist(), high]
            low, high = ends[step], ends[step + 1]
        found.append((0.5 * (low + high), not begins))
    return found
