# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The linear matrices of all ends of scenarios, each made once for what decides it; code of other
packages is tried before its model is believed.

Whether the state of a controller or a coupling from outside the library is all in what it returns,
and whether it is linear at the amplitudes of a session, only its author knows; so both are tried:

- Two hyperperiods in a row have to be the model applied twice. A state kept elsewhere is at rest
  in the first one only.
- The model has to be the same at the amplitude of a motion as at the tiny one of
  :mod:`.response`: a dead zone, a limit or a product of signals makes another one.

What changes at larger signals only, or never within two hyperperiods, is not seen: the notes of
every answer say so.
"""

import dataclasses
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from pmwvc_analysis.models.ends import PerturbedServer, PerturbedUser
from pmwvc_analysis.models.linear import (
    NonlinearError,
    amplitude_of,
    axes_of,
    outside,
    require_linear,
)
from pmwvc_analysis.models.links import LinkTimes, hyperperiod_ticks, link_times
from pmwvc_analysis.models.response import ONE, EndMatrix, Response, placed, reduced
from pmwvc_analysis.models.variation import changed
from pmwvc_core.controllers.library import PLAIN
from pmwvc_core.errors import PLUGIN_ERRORS, PmwvcError, reason
from pmwvc_core.numeric import Array, Integers
from pmwvc_core.params import ServerParams
from pmwvc_core.scenario.names import varied
from pmwvc_core.scenario.scenario import Scenario, User

LONGEST = 20000  # ticks of a hyperperiod
USUAL = User("")
SERVER = ServerParams()
OF_BOTH = ("name", "side", "master", "baseline", "own", "safety")  # of a user
EQUAL = 1e-9  # relative to the largest entry
FRAME_TICKS = 8  # on the strict channel


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
        different = tuple({id(run): run for run in of_runs}.values())
        numbers = {id(run): number for number, run in enumerate(different)}
        which = np.array([numbers[id(run)] for run in of_runs])
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
    if ticks > LONGEST:
        raise PmwvcError(
            f"{scenario.name}: frames and server period fit together only after {ticks} "
            f"ticks, more than {LONGEST}; choose rate_drop and period_s with common factors"
        )
    times = [link_times(user, scenario, live=live) for user in scenario.users]
    patterns = tuple(LinkTimes(up.pattern, down.pattern, taken) for up, down, taken in times)
    found: list[tuple[tuple[Any, ...], list[Scenario]]] = []
    for i, each in enumerate(patterns):
        fed = any(run.users[i].master.position.is_on for run in runs)
        alone = each._replace(up=each.up._replace(delay=0))
        of_user = _decisive(runs, slice(i, i + 1), "device")
        found.append(((PerturbedUser, ticks, dof, alone, fed), of_user))
    return [
        *found,
        ((PerturbedServer, ticks, dof, patterns), _decisive(runs, slice(None), "contact")),
    ]


def _try(runs: Sequence[Scenario], what: str, live: bool) -> None:
    """Try code of other packages; NonlinearError where it has no model."""
    try:
        for (kind, *given), of_runs in ends_of(as_tried(runs), live):
            response = Response(kind(list(dict.fromkeys(of_runs)), *given))
            require_tried(response, what, amplitude_of(runs[0])[1])
    except PmwvcError:
        raise
    except PLUGIN_ERRORS as error:  # whatever a plug-in raises
        raise NonlinearError(f"{what}: not perturbed: {reason(error)}") from error


def _decisive(runs: Sequence[Scenario], users: slice, group: str) -> list[Scenario]:
    """Return of each run what decides an end: some groups of users, and those of the server where
    contacts are; the same scenario where they are the same.
    """
    made, found = dict[tuple[int, ...], Scenario](), []
    for run in runs:
        parts = [
            {name: getattr(user, name) for name in (*OF_BOTH, group)} for user in run.users[users]
        ]
        server = run.server if group == "contact" else SERVER
        key = (id(server), *(id(each) for part in parts for each in part.values()))
        if key not in made:
            own = tuple(changed(USUAL, **part) for part in parts)
            server = changed(server, period_s=run.server.period_s)
            made[key] = changed(run, users=own, server=server)
        found.append(made[key])
    return found


@lru_cache(maxsize=16)
def made_once(kind: Any, runs: tuple[Scenario, ...], forces: bool, *given: Any) -> EndMatrix:
    """Return the matrix of an end, of its states that matter there."""
    found = Response(kind(runs, *given), forces).matrix()
    kept, matrix = reduced(found.matrix, placed(found.states))
    return found._replace(states=[found.states[j] for j in kept], matrix=matrix)


def as_tried(runs: Sequence[Scenario]) -> Sequence[Scenario]:
    """Return the scenarios by which code of other packages is tried: a coupling on the plain
    channel; a strict master with frames as long as steps, where playouts hold the same after every
    hyperperiod.
    """
    if amplitude_of(runs[0])[0]:
        period_s = FRAME_TICKS * runs[0].tick_s
        return [
            varied(varied(run, "master.rate_drop", FRAME_TICKS), "server.period_s", period_s)
            for run in runs
        ]
    if runs[0].strict:
        return [dataclasses.replace(run, channel=PLAIN) for run in runs]
    return runs


def require_tried(response: Response, what: str, amplitude: float) -> None:
    """Refuse an end that is not linear, or not the same again."""
    once = response.matrix()
    n = len(once.states)
    names = [*(name for name, _ in once.states), *(signal.name for signal in once.sent)]

    def other(one: Array, another: Array) -> str:
        """Return the names of the rows that differ; empty where none does."""
        off = np.abs(one - another).max(axis=(0, 2), initial=0.0) > EQUAL * np.abs(one).max()
        return ", ".join(sorted({names[row] for row in np.flatnonzero(off)}))

    after = once.matrix[:, :n]
    twice = after[:, :, :n] @ after
    twice[:, :, n:] += after[:, :, n:]
    if found := other(twice, response.matrix(rounds=2).matrix[:, :n]):
        raise NonlinearError(
            f"{what}: two hyperperiods in a row are not the model applied twice, in {found}: "
            "it keeps state elsewhere than in what it returns, or changes with time"
        )
    if found := other(once.matrix, response.matrix(one=amplitude).matrix):
        raise NonlinearError(
            f"{what}: not linear: signals of {amplitude:.2g} and of {ONE:.1g} (in SI units) "
            f"give different models, in {found}; use 'pmwvc simulate'"
        )
