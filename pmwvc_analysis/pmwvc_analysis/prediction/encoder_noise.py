# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy that an encoder sends as waves without a hand that gives it.

With steps q the positions measured have the rounding error e, evenly spread over q where a grip
chatters over several counts. The difference quotient (e_k - e_{k-1})/T_c goes into u_m, and what
the anti-aliasing filter lets through is in the packets:

    P = b q^2/(12 T_c^2) sum (h_k - h_{k-1})^2,    h: impulse response of the filter

so b q^2/(6 (M T_c)^2) for integrate-and-dump. The hand does not feel it, the environment gets it.

Equations: docs/theory.md 14.4.
"""

import numpy as np

from pmwvc_core.scenario.scenario import User
from pmwvc_core.wave.impedance import largest
from pmwvc_core.wave.rates import AntiAliasing

TICKS = 4000


def encoder_noise_w(user: User) -> float:
    """Return the power of an encoder's noise in the packets of a user [W]."""
    device, master = user.device, user.master
    if not device.differences or device.encoder_step_m <= 0.0:
        return 0.0
    ticks = master.rate_drop if master.filter.means else TICKS
    filtering = AntiAliasing(master.filter, tick_s=master.tick_s, rate_drop=master.rate_drop)
    if master.filter.means:
        response = np.full(ticks, 1.0 / ticks)
    else:
        response = np.array([float(filtering.step(1.0 if k == 0 else 0.0)) for k in range(ticks)])
    change = np.diff(response, prepend=0.0, append=0.0)
    variance = float(device.encoder_step_m) ** 2 / 12.0 / master.tick_s**2
    return float(largest(user.impedance)) * variance * float(np.sum(change**2))
