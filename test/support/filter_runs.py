# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One filter of each kind, and a trace through it."""

from pmwvc_core.params import FilterParams
from pmwvc_core.wave.rates import AntiAliasing
from support.strategies import TICK_S

BUTTERWORTH = FilterParams(kind="butterworth", pass_hz=25.0, stop_hz=50.0)
KINDS = [
    FilterParams(kind="none"),
    FilterParams(kind="first_order", pole_rad_s=100.0),
    BUTTERWORTH,
    FilterParams(kind="integrate_and_dump"),
]


def run(params, u, *, rate_drop=8):
    """Return the filtered ticks and the packets of a trace, as arrays."""
    stage = AntiAliasing(params, tick_s=TICK_S, rate_drop=rate_drop)
    ticks, packets = [], []
    for k, value in enumerate(u):
        if k % rate_drop == 0:
            packets.append(stage.sample())
        ticks.append(stage.step(value))
    return ticks, packets
