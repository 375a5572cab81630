# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The force that a hand feels: how abruptly it changes, and for how long it is missing.

A *step* is a change of the applied force within 1 ms, a *blow* one of more than ``BLOW_N``. Left
out is what an impact makes, ``IMPACT_S`` from the instant at which the avatar makes contact.
Nothing is known across what was not recorded; where a loop stood still, its last force stayed on.

The *undisturbed force* is the median while the master is coupled and the avatar touches. It is
defined where the hand means to hold a force (a simulated hand or a constant force on a simulated
device), from ``BLOW_N`` on. Time below half of it counts from the first tick at which a hand that
has closed feels it.

*Disturbed* is a user that is not coupled, or has less than half of its undisturbed force, though
the scenario does not take that away (:mod:`.taken_away`).
"""

from typing import NamedTuple

import numpy as np

from pmwvc_analysis.traces.stretches import gaps
from pmwvc_analysis.traces.taken_away import coupled, taken_away
from pmwvc_core.master.safety import SafetyState
from pmwvc_core.numeric import Array, Flags
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.traces import ServerTraces, SessionTraces, UserTraces

STEP_S = 1e-3
BLOW_N = 0.3  # a fifth of a grip of 1.6 N: twice to three times what fingers can tell apart
IMPACT_S = 0.5  # the longest way back to the hand, and the bounces
TOUCH_N = 0.02  # a force of the environment from which on an avatar touches it


class Felt(NamedTuple):
    """The steps and dropouts of a user's force; None: not defined.

    Attributes
    ----------
    force_step_max_n, force_step_max_s
        Largest step, and when.
    blows
        How often a blow began.
    force_undisturbed_n, force_least_n, dropout_s
        Undisturbed force, least force since it was first felt, time below half of it.
    coupled_ratio, disturbed_s
        Ratio of its time in which the user was coupled; time disturbed, None without a scenario.
    """

    force_step_max_n: float
    force_step_max_s: float
    blows: int
    force_undisturbed_n: float | None
    force_least_n: float | None
    dropout_s: float | None
    coupled_ratio: float
    disturbed_s: float | None


def felt(traces: SessionTraces, user: UserTraces, scenario: Scenario | None) -> Felt:
    """Return what a user felt."""
    known = next((u for u in scenario.users if u.name == user.name), None) if scenario else None
    holds = known is not None and _holds(known)
    server = traces.server
    touches = None
    if server is not None and user.name in server.users and len(server.time_s):
        touches = touching(server, server.users.index(user.name))
    steps = _steps(user)
    if server is not None and touches is not None:
        made_s = server.time_s[touches & ~np.concatenate([[False], touches[:-1]])]
        steps[_follow(made_s, user.time_s)] = 0.0
    worst, hard = int(np.argmax(steps)), steps > BLOW_N
    blows = int((hard & ~np.concatenate([[False], hard[:-1]])).sum())
    lasted_s, together = _lasted_s(user), coupled(traces, user)
    found = Felt(
        float(steps[worst]), float(user.time_s[worst]), blows, None, None, None,
        float(lasted_s[together].sum() / lasted_s.sum()), None,
    )  # fmt: skip
    if scenario is None or known is None:
        return found
    away = taken_away(traces, user, scenario)
    found = found._replace(disturbed_s=float(lasted_s[~together & ~away].sum()))
    if server is None or touches is None or not holds:
        return found
    size = np.linalg.norm(user.f_applied, axis=-1)
    row = np.searchsorted(server.time_s, user.time_s, side="right") - 1
    held = together & touches[np.maximum(row, 0)] & (row >= 0) & np.isfinite(size)
    undisturbed_n = float(np.median(size[held])) if held.any() else 0.0
    felt_at = held & (user.time_s >= closed_s(user, scenario)) & (size >= undisturbed_n)
    if undisturbed_n < BLOW_N or not felt_at.any():
        return found
    since = slice(int(np.argmax(felt_at)), None)
    below = size < 0.5 * undisturbed_n
    below[: since.start] = False
    return found._replace(
        force_undisturbed_n=undisturbed_n,
        force_least_n=float(np.nanmin(size[since])),
        dropout_s=float(lasted_s[below].sum()),
        disturbed_s=float(lasted_s[(below | ~together) & ~away].sum()),
    )


def touching(server: ServerTraces, index: int) -> Flags:
    """Tell at which steps of the server a user's avatar touches: where an environment reports no
    contact, its force tells.
    """
    touches = np.asarray(server.contact[index], dtype=bool)
    if touches.any():
        return touches
    return np.asarray(np.nan_to_num(np.linalg.norm(server.f_s[index], axis=-1)) > TOUCH_N)


def closed_s(user: UserTraces, scenario: Scenario) -> float:
    """Return when a simulated hand has closed [s]; 0 where it does not. Its time counts from the
    end of the soft start.
    """
    hands = {known.name for known in scenario.users if known.operator.is_hand}
    coupled = user.block_time_s[user.state == SafetyState.COUPLED]
    if not scenario.task.closes or user.name not in hands or not len(coupled):
        return 0.0
    return float(coupled[0]) + scenario.task.grip_s + scenario.task.grip_rise_s


def _holds(known: User) -> bool:
    return known.device.is_simulated and known.operator.kind in ("hand", "constant")


def _steps(user: UserTraces) -> Array:
    """Return by how much the force differs from one up to 1 ms before, for each tick [N]."""
    force = user.f_applied
    broken = np.zeros(len(force), dtype=int)
    broken[gaps(user) + 1] = 1
    broken[1:] += np.diff(user.tick) < 0
    piece = np.cumsum(broken)
    steps = np.zeros(len(force))
    for lag in range(1, max(1, round(STEP_S / user.tick_s)) + 1):
        size = np.linalg.norm(force[lag:] - force[:-lag], axis=-1)
        size = np.where((piece[lag:] == piece[:-lag]) & np.isfinite(size), size, 0.0)
        steps[lag:] = np.maximum(steps[lag:], size)
    return steps


def _follow(made_s: Array, time_s: Array) -> Flags:
    """Tell which instants closely follow a contact that was made [s]."""
    latest = np.searchsorted(made_s, time_s, side="right") - 1
    return np.asarray((latest >= 0) & (time_s < np.append(made_s, 0.0)[latest] + IMPACT_S))


def _lasted_s(user: UserTraces) -> Array:
    """Return how long the force of each tick stayed on, as far as that is on record [s]."""
    lasted = np.append(np.diff(user.time_s), user.tick_s)
    lasted[gaps(user)] = user.tick_s
    lasted[:-1][np.diff(user.tick) < 0] = user.tick_s
    return lasted
