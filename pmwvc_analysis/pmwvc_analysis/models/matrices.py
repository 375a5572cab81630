# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The linear matrices of all ends of scenarios, each made once for what decides it; code of other
packages is tried before its model is believed.

Whether a controller or a coupling from outside the library is linear at the amplitudes of a
session only its author knows; so it is tried: the model has to be the same at the amplitude of a
motion as at the tiny one of :mod:`.response`. A dead zone, a limit or a product of signals makes
another one; state kept elsewhere than in what is returned breaks superposition. What changes at
larger signals only is not seen: the notes of every answer say so.
"""

import dataclasses
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from pmwvc_analysis.models.ends import PerturbedServer, PerturbedUser
from pmwvc_analysis.models.linear import (
    AMPLITUDE,
    NonlinearError,
    axes_of,
    outside,
    require_linear,
)
from pmwvc_analysis.models.links import LinkTimes, hyperperiod_ticks, link_times
from pmwvc_analysis.models.response import ONE, EndMatrix, Response, placed, reduced
from pmwvc_analysis.models.variation import changed
from pmwvc_core.controllers.library import PLAIN
from pmwvc_core.errors import PLUGIN_ERRORS, PmwvcError, reason
from pmwvc_core.numeric import Integers
from pmwvc_core.params import ServerParams
from pmwvc_core.scenario.scenario import Scenario, User

USUAL = User("")
SERVER = ServerParams()
OF_BOTH = ("name", "side", "master", "baseline", "own", "given_safety")  # of a user
EQUAL = 1e-9  # relative to the largest entry


def matrices(
    runs: Sequence[Scenario], live: bool, outputs: bool = False
) -> list[tuple[EndMatrix, Integers]]:
    """Return every end of all runs that differ there, users before the server, and which of them
    each run has; parameters and errors as :func:`loop_of`.
    """
    ends, found = ends_of(runs, live), []
    if names := outside(runs[0]):
        _try(runs, f"{runs[0].name}: {', '.join(names)}", live)
    for (kind, *given), of_runs in ends:
        different = tuple(dict.fromkeys(of_runs))
        numbers = {run: number for number, run in enumerate(different)}
        which = np.array([numbers[run] for run in of_runs])
        found.append(
            (made_once(kind, different, outputs and kind is PerturbedUser, *given), which)
        )
    return found


def ends_of(runs: Sequence[Scenario], live: bool) -> list[tuple[tuple[Any, ...], list[Scenario]]]:
    """Return every end of scenarios: how it is made, and of which scenario for each run, with what
    decides it alone.
    """
    scenario = runs[0]
    require_linear(scenario)
    ticks, dof = hyperperiod_ticks(scenario), axes_of(scenario)
    times = [link_times(user, scenario, live=live) for user in scenario.users]
    patterns = tuple(LinkTimes(up.pattern, down.pattern, taken) for up, down, taken in times)
    found: list[tuple[tuple[Any, ...], list[Scenario]]] = []
    for i, each in enumerate(patterns):
        fed = any(run.users[i].master.position.is_on for run in runs)
        alone = each._replace(up=each.up._replace(delay=0))
        of_user = _decisive(runs, slice(i, i + 1), "given_device")
        found.append(((PerturbedUser, ticks, dof, alone, fed), of_user))
    return [
        *found,
        ((PerturbedServer, ticks, dof, patterns), _decisive(runs, slice(None), "contact")),
    ]


def _try(runs: Sequence[Scenario], what: str, live: bool) -> None:
    """Try code of other packages, on the plain channel: a strict one passes a wave only if its
    energy has come; NonlinearError where it has no model.
    """
    touching = [(run, tuple(user.in_contact for user in run.users)) for run in runs]
    plain = [dataclasses.replace(run, channel=PLAIN, users=users) for run, users in touching]
    try:
        for (kind, *given), of_runs in ends_of(plain, live):
            for run in dict.fromkeys(of_runs):
                require_tried(Response(kind(run, *given)), what)
    except PmwvcError:
        raise
    except PLUGIN_ERRORS as error:  # whatever a plug-in raises
        raise NonlinearError(f"{what}: not perturbed: {reason(error)}") from error


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
    each = [Response(kind(run, *given), forces, ends[0]).matrix(states) for run in runs]
    kept, matrix = reduced(np.concatenate([found.matrix for found in each]), placed(states))
    return each[0]._replace(states=[states[j] for j in kept], matrix=matrix)


def require_tried(response: Response, what: str) -> None:
    """Refuse an end that is not linear at the amplitude of a motion."""
    small, large = response.matrix(), response.matrix(one=AMPLITUDE)
    names = [*(name for name, _ in small.states), *(signal.name for signal in small.sent)]
    off = np.abs(small.matrix - large.matrix).max(axis=(0, 2), initial=0.0)
    wrong = np.flatnonzero(off > EQUAL * np.abs(small.matrix).max())
    if found := ", ".join(sorted({names[row] for row in wrong})):
        raise NonlinearError(
            f"{what}: not linear: signals of {AMPLITUDE:.2g} and of {ONE:.1g} (in SI units) "
            f"give different models, in {found}; use 'pmwvc simulate'"
        )
