# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The work that one question may cost: some 4 s on one core, counted before it is done.

What it takes is known from sizes alone (ticks, states, runs), so an answer never depends on how
busy a machine is. A question that needs more has the answer "not known".
"""

from collections.abc import Sequence

from pmwvc_analysis.delays.long_delay import is_long
from pmwvc_analysis.delays.windings import Loci
from pmwvc_analysis.models.linear import axes_of
from pmwvc_analysis.models.links import hyperperiod_ticks
from pmwvc_analysis.models.variation import lengths
from pmwvc_core.errors import PmwvcError
from pmwvc_core.numeric import Array
from pmwvc_core.plural import count
from pmwvc_core.scenario.scenario import Scenario

ALLOWED = 4e9  # about nanoseconds, as measured on one core of 2024
TICK, ENTRY = 2.5e5, 1e2  # of one user in one tick, and of every number it steps
STATES = 30  # of a user, before they are counted
CUBE = 10.0  # eigenvalues of a matrix, per n^3
CIRCLE = 2e5  # of loci around long delays, per state and per signal that goes round


class UnknownError(PmwvcError, ValueError):
    """A question needs more work than it may."""


class Work:
    """Work done for a question about a scenario; one with columns is as many questions."""

    def __init__(self, scenario: Scenario) -> None:
        self._scenario, self._done = scenario, 0.0
        self._allowed = ALLOWED * max(lengths(scenario), default=1)

    def stepping(self, part: Scenario) -> None:
        """Count bringing a loop to rest, and stepping it around its hyperperiod."""
        ticks, runs, users = hyperperiod_ticks(part), max(lengths(part), default=1), part.users
        longest_s = max(way.delay_s for user in users for way in (user.link_up, user.link_down))
        before = 0.0 if is_long(part) else 2.0 * longest_s / part.tick_s
        entries = ticks * ENTRY * runs * STATES * axes_of(part) * len(users)
        self._count(len(users) * ((3 * ticks + before) * TICK + entries), "")

    def eigenvalues(self, matrices: Array) -> None:
        """Count finding the eigenvalues of matrices ``(runs, n, n)``."""
        runs, states = matrices.shape[:2]
        self._count(CUBE * runs * states**3, f"{states} states")

    def circles(self, loops: Sequence[Loci], each: int) -> None:
        """Count drawing so many circles of each loop."""
        for signals, states in (loop.size for loop in loops):
            work = each * CIRCLE * max(states, 1) * signals
            self._count(work, f"packets of {count(signals, 'signal')} on a long way")

    def _count(self, more: float, what: str) -> None:
        self._done += more
        if self._done > self._allowed:
            sizes = [f"a hyperperiod of {hyperperiod_ticks(self._scenario)} ticks", what]
            raise UnknownError(
                f"{self._scenario.name}: not known: {', '.join(filter(None, sizes))}: too much "
                "work for the exact model; equal master.rate_drop and server.period_s (or common "
                "factors) and shorter delays need less, 'pmwvc simulate' needs none"
            )
