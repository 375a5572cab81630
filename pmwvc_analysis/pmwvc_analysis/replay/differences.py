# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The differences between a replay and its recording.

With unchanged parameters a replay of a simulated session is the recording, to rounding. So is that
of a live one, as long as every packet is taken in, and every hand begins, at the tick at which it
did. What the recording leaves open is the arrival of packets that carried a wave of zero or the
wave of their neighbour, to about 0.2 ms: a hand may begin a frame earlier or later. ``FORCE_N``
and ``POSITION_M`` are what that may make.
"""

from typing import Any

import numpy as np

from pmwvc_analysis.replay.arrivals import tick_numbers
from pmwvc_analysis.traces import reductions
from pmwvc_core.numeric import Array
from pmwvc_core.traces import SessionTraces

FORCE_N = 0.1
POSITION_M = 0.5e-3


def differences(recorded: SessionTraces, replayed: SessionTraces) -> list[dict[str, Any]]:
    """Return per user the largest and RMS difference, tick by tick, of force and position."""
    others = {user.name: user for user in replayed.users}
    found = []
    for user in recorded.users:
        other = others[user.name]
        _, mine, theirs = np.intersect1d(
            tick_numbers(user.time_s, user.tick_s),
            tick_numbers(other.time_s, user.tick_s),
            return_indices=True,
        )
        force = user.f_applied[mine] - other.f_applied[theirs]
        position = user.x_m[mine] - other.x_m[theirs]
        found.append(
            {
                "name": user.name,
                "ticks": len(mine),
                "force_max_n": _largest(force),
                "force_rms_n": reductions.rms(force),
                "position_max_m": _largest(position),
                "position_rms_m": reductions.rms(position),
            }
        )
    return found


def reproduced(found: list[dict[str, Any]]) -> bool:
    """Tell whether force and position were met within the tolerance of a live session."""
    return all(
        user["force_max_n"] is not None
        and user["position_max_m"] is not None
        and user["force_max_n"] <= FORCE_N
        and user["position_max_m"] <= POSITION_M
        for user in found
    )


def _largest(values: Array) -> float | None:
    lengths = np.linalg.norm(values, axis=-1)
    return reductions.number(lengths.max()) if len(lengths) else None
