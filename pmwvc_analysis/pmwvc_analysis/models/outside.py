# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Code of other packages in the exact model: it is checked before its model is believed.

Whether the state of a controller or a coupling from outside the library is all in what it returns,
and whether it is linear at the amplitudes of a session, only its author knows; so both are tried:

- Two hyperperiods in a row have to be the model applied twice. A state kept elsewhere is at rest
  in the first one only.
- The model has to be the same at the amplitude of a motion as at the tiny one of
  :mod:`.hyperperiod`: a dead zone, a limit or a product of signals makes another one.

What changes at larger signals only, or never within two hyperperiods, is not seen: the notes of
every answer say so.
"""

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np

from pmwvc_analysis.models.hyperperiod import ONE, Hyperperiod
from pmwvc_analysis.models.linear import NonlinearError, amplitude_of, outside
from pmwvc_core.controllers.library import PLAIN
from pmwvc_core.errors import PLUGIN_ERRORS, PmwvcError, reason
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.names import varied
from pmwvc_core.scenario.scenario import Scenario

EQUAL = 1e-9  # relative to the largest entry
FRAME_TICKS = 8  # on the strict channel


def checked(*runs: Scenario, live: bool = False, weights: Sequence[int] = ()) -> Hyperperiod:
    """Return the loop of scenarios, code of other packages having been tried; NonlinearError if
    that is not linear or keeps state elsewhere, PmwvcError if the hyperperiod is too long.
    """
    if found := outside(runs[0]):
        what = f"{runs[0].name}: {', '.join(found)}"
        try:
            _check(runs, what, live=live, weights=weights)
        except PmwvcError:
            raise
        except PLUGIN_ERRORS as error:  # whatever a plug-in raises
            raise NonlinearError(f"{what}: not perturbed: {reason(error)}") from error
    return Hyperperiod(*runs, live=live, weights=weights)


def _check(runs: Sequence[Scenario], what: str, *, live: bool, weights: Sequence[int]) -> None:
    """Refuse what is not linear, or not the same again: a coupling on the plain channel; a strict
    master with frames as long as steps, where playouts hold the same after every hyperperiod.
    """
    tried, (strict, amplitude) = runs, amplitude_of(runs[0])
    if strict:
        period_s = FRAME_TICKS * runs[0].tick_s
        tried = [
            varied(varied(run, "master.rate_drop", FRAME_TICKS), "server.period_s", period_s)
            for run in runs
        ]
    elif runs[0].strict:
        tried = [dataclasses.replace(run, channel=PLAIN) for run in runs]

    def around(**asked: Any) -> tuple[Hyperperiod, Array]:
        loop = Hyperperiod(*tried, live=live, weights=weights)
        return loop, loop.around(**asked)[0]

    def other(one: Array, another: Array) -> str:
        """Return the names of the states that differ; empty where none does."""
        off = np.abs(one - another).max(axis=(0, 2), initial=0.0) > EQUAL * np.abs(one).max()
        names = [name for name, _ in loop.paths]
        return ", ".join(sorted({names[row] for row in np.flatnonzero(off)}))

    loop, once = around()
    if names := other(once @ once, around(rounds=2)[1]):
        raise NonlinearError(
            f"{what}: two hyperperiods in a row are not the model applied twice, in {names}: "
            "it keeps state elsewhere than in what it returns, or changes with time"
        )
    if names := other(once, around(one=amplitude)[1]):
        raise NonlinearError(
            f"{what}: not linear: signals of {amplitude:.2g} and of {ONE:.1g} (in SI units) "
            f"give different models, in {names}; use 'pmwvc simulate'"
        )
