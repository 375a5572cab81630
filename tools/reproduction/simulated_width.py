# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Z-width without a model: the largest stable stiffness for a contact damping, simulated.

Sessions that are simulated need no linearity, so they also cover what the exact model refuses
(energetic compensation, a ledger, one-sided contacts). A small constant force pushes the device; a
session is stable where the motion dies out: its RMS velocity in the last quarter is
``decay_ratio`` times that of the quarter before or less, and no safety limit had to act. For a
linear loop that is a number just below one; what is not linear may swing on at the same size for
ever, so there it has to fall clearly, and long sessions keep the bias small.
"""

import dataclasses
from typing import NamedTuple

import numpy as np

from pmwvc_analysis.models.linear import nonlinear
from pmwvc_core.params import OperatorParams, TaskParams
from pmwvc_core.scenario.names import varied
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.session import simulate
from pmwvc_core.traces import SessionTraces

PUSH_N = 0.01  # so small that growth shows long before a limit acts
AT_REST_M_S = 1e-9
LINEAR_S, DECAY_RATIO = 6.0, 0.995  # length of a session, and quarter over quarter
LONG_S, CLEAR_RATIO = 16.0, 0.8  # the same for what is not linear


class Bracket(NamedTuple):
    """The largest stable stiffness lies between: ``low`` was stable (0: nothing was), ``high`` was
    not [N/m] (None: everything looked at was stable).
    """

    low: float
    high: float | None


def simulated_z_width(
    scenario: Scenario, damping: float, *, highest: float, parts: int = 8, rounds: int = 4
) -> Bracket:
    """Return a bracket of the largest stable stiffness for a contact damping [N s/m]: from 0 to
    ``highest`` [N/m], divided into ``parts`` again and again. The small push replaces the hands.
    """
    far = bool(nonlinear(scenario))
    duration_s, decay_ratio = (LONG_S, CLEAR_RATIO) if far else (LINEAR_S, DECAY_RATIO)
    users = tuple(
        dataclasses.replace(
            user, given_operator=OperatorParams(kind="constant", force=-user.side * PUSH_N)
        )
        for user in scenario.users
    )
    task = TaskParams(kind="free")
    base = dataclasses.replace(scenario, users=users, duration_s=duration_s, task=task)
    base = varied(base, "server.contact_damping", damping)

    def flag(traces: SessionTraces, _: Scenario) -> bool:
        return decays(traces, decay_ratio=decay_ratio)

    low, high, ends = 0.0, highest, 1  # the last point is looked at in the first round only
    for _ in range(rounds):
        points = np.linspace(low, high, parts + 1)[1 : parts + ends].tolist()
        runs = [varied(base, "server.contact_stiffness", stiffness) for stiffness in points]
        with np.errstate(over="ignore", invalid="ignore"):  # some run away beyond all numbers
            stable = [bool(each) for each in simulate(runs, keep=flag)]
        if ends and all(stable):
            return Bracket(highest, None)
        first = (*stable, False).index(False)  # stability is lost first there
        low, high, ends = [low, *points][first], [*points, high][first], 0
    return Bracket(low, high)


def decays(traces: SessionTraces, *, decay_ratio: float = DECAY_RATIO) -> bool:
    """Tell whether the motion of a session dies out, without help from the safety limits."""
    if any(int(user.safety_events) for user in traces.users):
        return False
    power = sum(np.sum(user.xd_m**2, axis=-1) for user in traces.users)
    quarter = len(power) // 4
    before, after = np.mean(power[-2 * quarter : -quarter]), np.mean(power[-quarter:])
    dies_out = after <= AT_REST_M_S**2 or after < decay_ratio**2 * before
    return bool(np.isfinite(after) and dies_out)
