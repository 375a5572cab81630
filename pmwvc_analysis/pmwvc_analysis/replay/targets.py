# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The remote hand of a recorded session: the same hand with the targets that it got, each at the
first tick that ran after its arrival.
"""

import numpy as np

from pmwvc_core.errors import RecordingError
from pmwvc_core.numeric import Integers, signal
from pmwvc_core.plant.forces import Operator
from pmwvc_core.plant.remote_hand import RemoteHand, Target
from pmwvc_core.plant.targets import GivenTargets
from pmwvc_core.scenario.scenario import User
from pmwvc_core.traces import SessionTraces


def remote_hand(
    user: User, traces: SessionTraces, ran_ns: Integers, *, tick_s: float, dof: int
) -> Operator:
    """Return the remote hand with recorded targets; RecordingError for a replay: it has none."""
    if not traces.live:
        raise RecordingError(
            f"{user.name}: a {traces.source} session holds no targets of a remote hand; replay "
            "the recording that it was made from"
        )
    hand = RemoteHand(user.operator, start=0.0, tick_s=tick_s, dof=dof)
    found = traces.targets.get(user.name)
    if found is None:
        hand.source = GivenTargets([], early=True)
        return hand
    ran = np.flatnonzero(ran_ns >= 0)
    rows = np.searchsorted(ran_ns[ran], np.rint(found.time_s * 1e9))
    taken = rows < len(ran)
    ticks = (ran[rows[taken]] - ran[0]).tolist()
    targets: list[Target] = [
        signal(point[:dof].tolist(), dof) if np.isfinite(point[:dof]).all() else None
        for point in found.position[taken]
    ]
    hand.source = GivenTargets(zip(ticks, targets, strict=True), early=True)
    return hand
