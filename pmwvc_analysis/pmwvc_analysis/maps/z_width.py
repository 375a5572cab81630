# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Z-width without a model: the largest stable stiffness from sessions that are simulated.

It needs no linearity, so it also covers what the exact model refuses (energetic compensation, a
ledger, one-sided contacts). A small constant force pushes the device; a session is stable where
the motion dies out: its RMS velocity in the last quarter is ``decay_ratio`` times that of the
quarter before or less, and no safety limit had to act. For a linear loop that is a number just
below one; what is not linear may swing on at the same size for ever, so there it has to fall
clearly, and long sessions keep the bias small.

The interval between a stable and an unstable stiffness is divided into equal parts again and
again.
"""

import dataclasses
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from pmwvc_analysis.models.linear import nonlinear
from pmwvc_analysis.models.stability import BOUND, z_width
from pmwvc_core.errors import PmwvcError
from pmwvc_core.params import OperatorParams, TaskParams
from pmwvc_core.scenario.names import varied
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.session import simulate
from pmwvc_core.traces import SessionTraces

PUSH_N = 0.01  # so small that growth shows long before a limit acts
AT_REST_M_S = 1e-9
DECAY_RATIO = 0.995  # quarter over quarter, linear
LONG_S, CLEAR_RATIO = 16.0, 0.8  # length and ratio for what is not linear
HIGHEST_SIMULATED = 20_000.0  # [N/m]


class Bracket(NamedTuple):
    """The largest stable stiffness lies between: ``low`` was stable, ``high`` was not [N/m].

    ``low`` is zero where nothing was stable, ``high`` None where everything looked at was.
    """

    low: float
    high: float | None


def of_each(
    scenario: Scenario, damping: Sequence[float], *, bound: float | None, live: bool
) -> Iterator[tuple[float, Bracket]]:
    """Yield every contact damping [N s/m] with the bracket of its largest stiffness: of no width
    from the exact model, simulated where there is none.

    Raises
    ------
    PmwvcError
        If the exact model needs too much work, or phases of a live session are to be simulated.
    """
    is_linear = not nonlinear(scenario)
    if live and not is_linear:
        raise PmwvcError(f"{scenario.name} is not linear: it is simulated in virtual time only")
    for b in damping:
        if is_linear:
            (limit,) = z_width(scenario, [b], live=live, bound=bound or BOUND)
            if limit.unknown:
                raise PmwvcError(limit.unknown)
            bracket = Bracket(limit.bound if limit.first is None else limit.first, limit.first)
        else:
            highest = bound or HIGHEST_SIMULATED
            bracket = simulated_z_width(
                scenario, b, highest=highest, duration_s=LONG_S, decay_ratio=CLEAR_RATIO
            )
        yield b, bracket


def simulated_z_width(
    scenario: Scenario,
    damping: float,
    *,
    highest: float,
    parts: int = 8,
    rounds: int = 4,
    duration_s: float = 6.0,
    decay_ratio: float = DECAY_RATIO,
) -> Bracket:
    """Return a bracket of the largest stable stiffness for a contact damping.

    Parameters
    ----------
    scenario
        Everything else; what the hand does is replaced by the small push.
    damping
        Contact damping [N s/m].
    highest
        Largest stiffness looked at [N/m].
    parts, rounds
        The bracket is ``highest / parts**rounds`` wide in the end.
    duration_s
        Length of each session.
    decay_ratio
        Ratio of RMS velocities below which a motion dies out.
    """
    base = varied(_pushed(scenario, duration_s), "server.contact_damping", damping)

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


def _pushed(scenario: Scenario, duration_s: float) -> Scenario:
    users = tuple(
        dataclasses.replace(
            user, operator=OperatorParams(kind="constant", force=-user.side * PUSH_N)
        )
        for user in scenario.users
    )
    return dataclasses.replace(
        scenario, users=users, duration_s=duration_s, task=TaskParams(kind="free")
    )


def decays(traces: SessionTraces, *, decay_ratio: float = DECAY_RATIO) -> bool:
    """Tell whether the motion of a session dies out, without help from the safety limits."""
    if any(int(user.safety_events) for user in traces.users):
        return False
    power = sum(np.sum(user.xd_m**2, axis=-1) for user in traces.users)
    quarter = len(power) // 4
    before, after = (
        float(np.mean(power[-2 * quarter : -quarter])),
        float(np.mean(power[-quarter:])),
    )
    if not np.isfinite(after):
        return False
    return after <= AT_REST_M_S**2 or after < decay_ratio**2 * before
