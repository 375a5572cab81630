# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Stability from the exact model: spectral radius, largest stiffness, Z-width.

The largest stiffness is the first crossing: everything below it is stable. Where it becomes stable
again above, these islands are reported, too.

A question may cost some 4 s on one core, counted from sizes alone (ticks, states, runs) before it
is done: so an answer never depends on how busy a machine is. What costs more is "not known".
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from pmwvc_analysis.models.ends import PerturbedUser
from pmwvc_analysis.models.linear import require_linear
from pmwvc_analysis.models.linearize import Linear
from pmwvc_analysis.models.links import hyperperiod_ticks
from pmwvc_analysis.models.long_delays import Long, is_long
from pmwvc_analysis.models.loop import LinearLoop, loop_of
from pmwvc_analysis.models.matrices import ends_of
from pmwvc_analysis.models.variation import with_stiffness
from pmwvc_core.errors import PmwvcError
from pmwvc_core.numeric import Array, Flags
from pmwvc_core.scenario.names import varied
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.words import count

BOUND = 1e6  # [N/m] no contact stiffness above this is looked at
LOWEST = 0.1  # [N/m]
PER_DECADE = 10
LARGEST_BATCH = 512
ROUGHLY: dict[str, Any] = {"within": 1e-4, "parts": 5}  # where an evaluation is costly
RADIUS = 30  # circles to draw for a radius
ALLOWED = 4e9  # work of a question, about nanoseconds, as measured on one core of 2024
TICK = 4e4  # of one user in one tick, from one state
STATES = 12  # of a user at either end, before they are counted
EVALUATIONS = 200  # of a search for the largest stiffness
CUBE = 10.0  # eigenvalues of a matrix, per n^3
CIRCLE = 2e5  # of loci around long delays, per state and per signal that goes round


class UnknownError(PmwvcError, ValueError):
    """A question needs more work than it may."""


class StabilityWork:
    """Work done for a question about a scenario; that about several is as many questions."""

    def __init__(self, scenario: Scenario, questions: int = 1) -> None:
        self._scenario, self.left = scenario, ALLOWED * questions
        self._stepped = set[Scenario]()

    def stepping(self, runs: Sequence[Scenario], live: bool) -> None:
        """Count stepping all ends around their hyperperiod, from every state and packet, once."""
        for (kind, ticks, dof, *_), of_runs in ends_of(runs, live):
            new, users = set(of_runs) - self._stepped, of_runs[0].users
            self._stepped |= new
            steps = ticks if kind is PerturbedUser else ticks // runs[0].period_ticks
            packets = sum(2 * ticks // user.master.rate_drop for user in users)
            columns = (STATES * len(users) + packets) * dof
            self.count(TICK * columns * steps * len(users) * len(new))

    def count(self, more: float, what: str = "") -> None:
        """Count work on something; UnknownError where it is more than allowed."""
        self.left -= more
        if self.left < 0.0:
            sizes = [f"a hyperperiod of {hyperperiod_ticks(self._scenario)} ticks", what]
            raise UnknownError(
                f"{self._scenario.name}: not known: {', '.join(filter(None, sizes))}: too much "
                "work for the exact model; equal master.rate_drop and server.period_s (or common "
                "factors) and shorter delays need less, 'pmwvc simulate' needs none"
            )


class StabilityLimit(NamedTuple):
    """The limit of stability along one parameter.

    ``first`` is where stability is lost: 0: the lowest value is unstable, None: none up to
    ``bound`` is.
    """

    first: float | None
    bound: float
    islands: list[tuple[float, float]]  # stable ranges above
    unknown: str = ""  # why it is not known


def radii(*runs: Scenario, live: bool = False) -> Array:
    """Return the spectral radii ``(runs,)`` over the hyperperiod of scenarios that differ in what
    is :func:`.stackable`; UnknownError where that is more work than allowed.
    """
    for run in runs[1:]:  # the first one is looked at by each loop
        require_linear(run)
    model = _model(runs, StabilityWork(runs[0], len(runs)), live=live, circles=RADIUS)
    return model.radii()


def _model(
    runs: Sequence[Scenario], work: StabilityWork, *, live: bool, circles: int
) -> Linear | Long:
    """Return the model of scenarios; work is counted before it is done, so many circles for one
    with long delays.
    """
    work.stepping(runs, live)
    model = model_of(loop_of(*runs, live=live))
    if isinstance(model, Long):
        for signals, states in (loci.size for loci in model.loci):
            cost = circles * CIRCLE * max(states, 1) * signals
            work.count(cost, f"packets of {count(signals, 'signal')} on a long way")
    else:
        states = model.count - int(model.quotient[1].min())
        work.count(CUBE * len(runs) * states**3, f"{states} states")
    return model


def model_of(loop: LinearLoop) -> Linear | Long:
    """Return the model of loops: of a matrix, or with long delays apart."""
    return Long(loop) if is_long(loop) else Linear(loop)


def k_max(scenario: Scenario, *, live: bool = False, bound: float = BOUND) -> StabilityLimit:
    """Return the largest contact stiffness [N/m], all in proportion; unknown: too much work."""
    work = StabilityWork(scenario)

    def at(stiffness: Array) -> Flags:
        """Tell where the loop is stable: quicker than radii at long delays."""
        stiff = [with_stiffness(scenario, each) for each in stiffness]
        return _model(stiff, work, live=live, circles=1).stable()

    try:
        for stiffness in (bound, LOWEST):
            before = work.left
            at(np.array([stiffness]))
        fine = float(np.clip(0.5 * before / (EVALUATIONS * (before - work.left)), 0.4, 1.0))
        points = 1 + int(np.ceil(np.log10(bound / LOWEST) * PER_DECADE * fine))
        grid = np.geomspace(LOWEST, bound, points)
        changes = crossings(at, grid, **({} if fine == 1.0 else ROUGHLY))
    except UnknownError as error:
        return StabilityLimit(None, bound, [], str(error))
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


def z_width(
    scenario: Scenario, damping: Sequence[float], *, live: bool = False, bound: float = BOUND
) -> list[StabilityLimit]:
    """Return the largest stiffness for each contact damping [N s/m] that can be rendered."""
    walls = (varied(scenario, "server.contact_damping", b) for b in damping)
    return [k_max(wall, live=live, bound=bound) for wall in walls]
