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

from pmwvc_analysis.models.linearize import Linear, model_of
from pmwvc_analysis.models.outside import checked
from pmwvc_core.errors import PmwvcError
from pmwvc_core.scenario.scenario import Scenario

LARGEST_LIFTED = 4000  # users times ticks times axes
LARGEST_STATES = 3000  # of a model with inputs and outputs: some 10 s and 200 MB


def build(scenario: Scenario, *, live: bool = False, weights: Sequence[int] = ()) -> Linear:
    """Return the exact model of a scenario of plain numbers, with inputs and outputs; see
    :class:`.loop.Loop` for what is asked.

    Raises
    ------
    NonlinearError
        If an element is not linear.
    PmwvcError
        If the hyperperiod is too long, or there are too many states or inputs.
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
    return model_of(loop, *loop.around(inputs=True, outputs=True))


def spectral_radius(model: Linear) -> float:
    """Return the largest length of an eigenvalue of A on the quotient by rigid motions."""
    return float(model.radii()[0])
