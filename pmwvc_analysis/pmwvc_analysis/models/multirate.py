# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The exact model of a session over one hyperperiod.

All periods (frames of every user, steps of the server) fit into the hyperperiod a whole number of
times. Over it the state goes on by a constant matrix::

    z(n+1) = A z(n) + B f(n),      y(n) = C z(n) + D f(n)

with f the hands' forces held over every tick, and y motion and force at the start of every tick,
both lifted: user by user, tick by tick, axis by axis. A is the transition (monodromy) matrix:
stable is what has no eigenvalue outside the unit circle, apart from motions that are no
instability (:mod:`.rigid`).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pmwvc_analysis.models.linear import notes_of
from pmwvc_analysis.models.linearize import linearize, model_of
from pmwvc_analysis.models.motions import rigid
from pmwvc_analysis.models.outside import checked
from pmwvc_core.errors import PmwvcError
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario

LARGEST_LIFTED = 4000  # users times ticks times axes
LARGEST_STATES = 3000  # of a model with inputs and outputs: some 10 s and 200 MB


class Output(NamedTuple):
    """One lifted output y = C z + D f; rows, and columns of D, by
    ``(user * ticks + tick) * dof + axis``.
    """

    state: Array  # C, (users * ticks * dof, n)
    through: Array  # D, (users * ticks * dof, users * ticks * dof)


@dataclass(frozen=True)
class MultirateModel:
    """The model of one scenario.

    Attributes
    ----------
    transition
        A, ``(n, n)``.
    states
        Names of the n states.
    ticks, tick_s
        Length of the hyperperiod in ticks, and of a tick [s].
    dof
        Number of axes of the model: one where all axes have the same.
    inputs
        B, ``(n, users * ticks * dof)``, per N of a hand pushing the device.
    outputs
        ``x`` and ``xd`` (as measured) and ``f`` (of the controller, against the hand).
    rigid
        Motions that are no instability; see :mod:`.rigid`.
    notes
        Where the model stands for something else, in sentences.
    """

    scenario: Scenario
    live: bool
    weights: Sequence[int]
    transition: Array
    states: list[str]
    ticks: int
    tick_s: float
    dof: int
    users: list[str]
    inputs: Array
    outputs: dict[str, Output]
    rigid: list[rigid.Family]
    notes: list[str]


def build(
    scenario: Scenario, *, live: bool = False, weights: Sequence[int] = ()
) -> MultirateModel:
    """Return the exact model of a scenario, with inputs and outputs.

    Parameters
    ----------
    scenario
        What to model, with plain numbers.
    live
        Phases of a live session instead of the simulator's.
    weights
        How many equal users, that move together, each user stands for.

    Raises
    ------
    NonlinearError
        If an element is not linear.
    PmwvcError
        If the hyperperiod is too long.
    """
    loop = checked(scenario, live=live, weights=weights)
    lifted, states = len(loop.lines) * loop.ticks * loop.dof, len(loop.names) * loop.dof
    if states > LARGEST_STATES:
        raise PmwvcError(
            f"{scenario.name}: {states} states, nearly all of them packets in flight, "
            f"more than {LARGEST_STATES}; shorten link.delay_s (pmwvc stability takes any delay)"
        )
    if lifted > LARGEST_LIFTED:
        raise PmwvcError(
            f"{scenario.name}: {lifted} inputs (users times ticks of the hyperperiod, along each "
            f"axis), more than {LARGEST_LIFTED}; choose rate_drop and period_s with common factors"
        )
    linear = model_of(loop, *loop.around(inputs=True, outputs=True))
    n = len(linear.columns)
    return MultirateModel(
        scenario=scenario,
        live=live,
        weights=weights,
        transition=linear.rows[0, :, :n],
        states=linear.states,
        ticks=loop.ticks,
        tick_s=loop.tick_s,
        dof=loop.dof,
        users=[line.name for line in loop.lines],
        inputs=linear.rows[0, :, n:],
        outputs={name: Output(y[0, :, :n], y[0, :, n:]) for name, y in linear.outputs.items()},
        rigid=rigid.families(linear),
        notes=notes_of(scenario, live=live),
    )


class Transitions(NamedTuple):
    """Transition matrices ``(runs, n, n)`` of scenarios of equal structure."""

    matrices: Array
    states: list[str]
    ticks: int
    rigid: list[rigid.Family]


def transitions(
    scenario: Scenario,
    *,
    live: bool = False,
    weights: Sequence[int] = (),
) -> Transitions:
    """Return the transition matrices of a scenario whose numbers may be columns ``(runs, 1)``.

    With ``weights`` every user stands for so many equal ones that move together.
    """
    linear = linearize(scenario, live=live, weights=weights)
    return Transitions(linear.rows, linear.states, linear.loop.ticks, rigid.families(linear))


def reduced(model: MultirateModel) -> Array:
    """Return A on the quotient by rigid motions."""
    found: Array = rigid.quotient(model.transition[np.newaxis], model.rigid)[0]
    return found


def spectral_radius(model: MultirateModel) -> float:
    """Return the largest length of an eigenvalue of A on the quotient by rigid motions."""
    return float(rigid.radius(reduced(model)[np.newaxis])[0])
