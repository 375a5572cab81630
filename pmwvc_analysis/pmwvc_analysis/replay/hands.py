# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The hands of a replay: the recorded force, or a remote hand with the targets that it got."""

import numpy as np

from pmwvc_analysis.replay.loop_times import tick_numbers
from pmwvc_core.ends.simulated_device import CATCH_UP_S
from pmwvc_core.errors import RecordingError
from pmwvc_core.numeric import Flags, Integers
from pmwvc_core.plant.forces import RecordedForce, recorded_params
from pmwvc_core.plant.hands import Made
from pmwvc_core.plant.remote_hand import TableHand, TableParams, remote_params, resting_remote
from pmwvc_core.scenario.scenario import User
from pmwvc_core.traces import SessionTraces, UserTraces


def recorded_force(user: UserTraces, ran_ns: Integers, *, tick_s: float, dof: int) -> Made:
    """Return the recorded force, tick for tick; RecordingError where there is none.

    The force in ticks that did not run is interpolated; ``ran_ns`` is negative for these.
    """
    if not np.isfinite(user.f_h).any():
        raise RecordingError(
            f"{user.name}: no force of the hand was recorded; --hand operator takes the hand "
            "of the scenario"
        )
    at, force = tick_numbers(user.time_s, tick_s), np.nan_to_num(user.f_h)
    every = np.arange(len(ran_ns))
    rows = np.stack([np.interp(every, at, axis) for axis in force.T], axis=-1)
    recorded = at < len(ran_ns)
    rows[at[recorded]] = force[recorded]
    rows = rows[_passing(ran_ns, tick_s)]
    return RecordedForce(0), recorded_params(rows, dof, repeat=False, early=True)


def remote_hand(
    user: User, traces: SessionTraces, ran_ns: Integers, *, tick_s: float, dof: int
) -> Made:
    """Return the remote hand with recorded targets, each at the first tick that ran after its
    arrival; RecordingError for a replay: it has none.
    """
    if not traces.live:
        raise RecordingError(
            f"{user.name}: a {traces.source} session holds no targets of a remote hand; replay "
            "the recording that it was made from"
        )
    found = traces.targets.get(user.name)
    ticks, rows = np.zeros(0, dtype=np.int64), np.zeros((0, dof))
    if found is not None:
        ran = np.flatnonzero(ran_ns >= 0)
        next_ran = np.searchsorted(ran_ns[ran], np.rint(found.time_s * 1e9))
        taken = next_ran < len(ran)
        passed = np.cumsum(_passing(ran_ns, tick_s)) - 1
        ticks, rows = passed[ran[next_ran[taken]]], found.position[taken, :dof]
    p = TableParams(remote_params(user.operator, tick_s), ticks, rows, tuple(range(dof)), True)
    return TableHand(resting_remote((0.0,) * dof), 0, 0), p


def _passing(ran_ns: Integers, tick_s: float) -> Flags:
    """Tell in which ticks of the session a hand moves: those that ran, and after each as many that
    did not as a simulated device makes up for (``CATCH_UP_S``).
    """
    ran, every = ran_ns >= 0, np.arange(len(ran_ns))
    latest = np.maximum.accumulate(np.where(ran, every, -1))
    most = max(1, round(CATCH_UP_S / tick_s))
    return np.asarray((latest >= 0) & (every - latest < most))
