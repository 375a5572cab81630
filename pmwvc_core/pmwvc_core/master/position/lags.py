# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The lag of a wave in the filter and in the hold of a master, seen from packet to packet.

Equations: docs/theory.md 11.7.
"""

from pmwvc_core.numeric import Value
from pmwvc_core.params import MasterParams
from pmwvc_core.wave.design.aliasing import delay_of


def filter_lag_s(params: MasterParams) -> Value:
    """Return tau - (M-1)/2 T_c [s], tau the group delay of the anti-aliasing filter.

    A packet carries the end of its frame, which is (M-1)/2 T_c later than the mean of the frame.
    """
    tau = delay_of(params.filter, tick_s=params.tick_s, rate_drop=params.rate_drop)
    return tau - _half_frame_s(params)


def hold_lag_s(params: MasterParams) -> float:
    """Return (M-1)/2 T_c [s], by which the first-order hold comes late; zero for the other."""
    return _half_frame_s(params) if params.ramps else 0.0


def _half_frame_s(params: MasterParams) -> float:
    return 0.5 * (params.rate_drop - 1) * params.tick_s
