# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The linear matrices of all ends of scenarios, each made once for what decides it.

Of all states those matter that are read and driven, those present twice once: entries are exactly
zero or rows exactly equal in every run, so leaving others out changes no eigenvalue other than
zero, nor what follows from the inputs.
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from pmwvc_analysis.models.ends import PerturbedServer, PerturbedUser
from pmwvc_analysis.models.linear import NonlinearError, axes_of, outside, require_linear
from pmwvc_analysis.models.links import LinkTimes, hyperperiod_ticks, link_times
from pmwvc_analysis.models.response import EndMatrix, Response, placed
from pmwvc_analysis.models.variation import changed
from pmwvc_core.controllers.library import PLAIN
from pmwvc_core.errors import PLUGIN_ERRORS, PmwvcError, reason
from pmwvc_core.numeric import Array, Flags, Integers
from pmwvc_core.params import ServerParams
from pmwvc_core.scenario.scenario import Scenario, User

USUAL = User("")
SERVER = ServerParams()
OF_BOTH = ("name", "side", "master", "baseline", "own", "given_safety")  # of a user


def matrices(
    runs: Sequence[Scenario], live: bool, outputs: bool = False
) -> list[tuple[EndMatrix, Integers]]:
    """Return every end of all runs that differ there, users before the server, and which of them
    each run has; parameters and errors as :func:`loop_of`.
    """
    scenario = runs[0]
    require_linear(scenario)
    if outside(scenario) and scenario.strict:  # tried on the plain channel, in touch
        touching = [(run, tuple(user.in_contact for user in run.users)) for run in runs]
        matrices([changed(run, channel=PLAIN, users=users) for run, users in touching], live)
    ticks, dof = hyperperiod_ticks(scenario), axes_of(scenario)
    times = [link_times(user, scenario, live=live) for user in scenario.users]
    patterns = tuple(LinkTimes(up.pattern, down.pattern, taken) for up, down, taken in times)
    found = []
    for i, each in enumerate(patterns):
        fed = any(run.users[i].master.position.is_on for run in runs)
        alone = each._replace(up=each.up._replace(delay=0))
        of_user = _decisive(runs, slice(i, i + 1), "given_device")
        found.append(_end(PerturbedUser, of_user, outputs, ticks, dof, alone, fed))
    of_server = _decisive(runs, slice(None), "contact")
    return [*found, _end(PerturbedServer, of_server, False, ticks, dof, patterns)]


def _end(
    kind: Any, of_runs: Sequence[Scenario], forces: bool, *given: Any
) -> tuple[EndMatrix, Integers]:
    """Return an end of all runs that differ there, and which of them each run has."""
    numbers = {run: number for number, run in enumerate(dict.fromkeys(of_runs))}
    try:
        end = made_once(kind, tuple(numbers), forces, *given)
    except PmwvcError:
        raise
    except PLUGIN_ERRORS as error:
        if not (names := ", ".join(outside(of_runs[0]))):
            raise
        text = f"{of_runs[0].name}: {names}: not perturbed: {reason(error)}"
        raise NonlinearError(text) from error
    return end, np.array([numbers[run] for run in of_runs])


def _decisive(runs: Sequence[Scenario], users: slice, group: str) -> list[Scenario]:
    """Return of each run what decides an end: some groups of users, and those of the server where
    contacts are.
    """
    found = []
    for run in runs:
        own = (
            {name: getattr(user, name) for name in (*OF_BOTH, group)} for user in run.users[users]
        )
        server = run.server if group == "contact" else SERVER
        server = changed(server, period_s=run.server.period_s)
        found.append(changed(run, users=tuple(changed(USUAL, **of) for of in own), server=server))
    return found


@lru_cache(maxsize=64)
def made_once(kind: Any, runs: tuple[Scenario, ...], forces: bool, *given: Any) -> EndMatrix:
    """Return the matrices of an end, of the states that matter there in some run."""
    ends = [Response(kind(run, *given), forces) for run in dict.fromkeys((runs[0], runs[-1]))]
    states = list(dict.fromkeys(state for end in ends for state in end.states))
    others = (Response(kind(run, *given), forces, ends[0]) for run in runs[1:])
    each = [end.matrix(states) for end in (ends[0], *others)]
    kept, matrix = reduced(np.concatenate([found.matrix for found in each]), placed(states))
    return each[0]._replace(states=[states[j] for j in kept], matrix=matrix)


def reduced(whole: Array, always: Flags) -> tuple[list[int], Array]:
    """Return the states that matter, and the matrix on them alone.

    ``whole`` is ``(runs, n and signals, n and inputs)``: the n states after a step, and what is
    read of them otherwise; ``always`` are ``(n,)`` states that matter in any case.
    """
    n, whole = len(always), whole.copy()
    filled = np.any(whole != 0.0, axis=0)  # entries other than zero in any run
    kept = np.arange(n)
    while True:
        twins = _twins(whole, kept, always)
        for twin, first in twins.items():
            whole[:, :, first] += whole[:, :, twin]
            filled[:, first] = np.any(whole[:, :, first] != 0.0, axis=0)
        still = np.setdiff1d(kept, list(twins))
        own = still[:, np.newaxis] == np.arange(whole.shape[2])
        columns = np.r_[still, n : whole.shape[2]]
        driven = np.any((filled[still] & ~own)[:, columns], axis=1)
        others = filled[still] & ~(own & (whole[0, still] == 1.0))  # a sum only it reads is none
        seen = others.any(axis=0) | filled[n:].any(axis=0)
        left = still[always[still] | (driven & seen[still])]
        gone = np.setdiff1d(kept, left)
        whole[:, :, gone], filled[:, gone] = 0.0, False
        if len(left) == len(kept):
            rows = np.r_[kept, n : whole.shape[1]]
            return kept.tolist(), whole[:, rows[:, np.newaxis], np.r_[kept, n : whole.shape[2]]]
        kept = left


def _twins(whole: Array, kept: Integers, always: Flags) -> dict[int, int]:
    """Return states that are equal to an earlier one after every step."""
    first: dict[bytes, int] = {}  # by their rows in every run
    return {
        j: earlier
        for j in kept.tolist()
        if (earlier := first.setdefault((whole[:, j] + 0.0).tobytes(), j)) != j and not always[j]
    }
