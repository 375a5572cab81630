# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy that comes of an encoder's steps, on either channel.

**Plain channel.** With steps q the positions measured have the rounding error e, evenly spread
over q where a grip chatters over several counts. What the anti-aliasing filter H lets through of
the difference quotient (e_k - e_{k-1})/T_c is in the packets; the environment gets it:

    P = b q^2/(12 T_c^2) mean of |1 - 1/z|^2 |H|^2 over all frequencies

**Strict channel.** What the port of the hand releases is bounded by
:mod:`pmwvc_core.master.count_bound`, which needs a hand on the device.

Equations: docs/theory.md 14.4.
"""

import numpy as np

from pmwvc_analysis.budget.criterion import behind_counts, held
from pmwvc_core.master.count_bound import count_bound
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.wave.filter_design import response
from pmwvc_core.wave.impedance import largest

POINTS = 16384  # frequencies of a mean


def encoder_noise_w(user: User) -> float:
    """Return the power of an encoder's noise in the packets of a user [W]."""
    device, master = user.device, user.master
    if not device.differences or device.encoder_step_m <= 0.0:
        return 0.0
    tick_s, turn = master.tick_s, np.arange(POINTS) / POINTS
    passed = response(master.filter, turn / tick_s, tick_s=tick_s, rate_drop=master.rate_drop)
    differenced = np.mean(np.abs(2.0 * np.sin(np.pi * turn) * passed) ** 2)
    variance = float(device.encoder_step_m) ** 2 / 12.0 / tick_s**2
    return float(largest(user.impedance) * variance * differenced)


def encoder_lines(scenario: Scenario) -> list[str]:
    """Return in words what the ports behind such encoders may give out; nothing without one."""
    found = []
    for user in scenario.users:
        if not behind_counts(user, scenario):
            continue
        words = f"{user.name}: {count_bound(user.master, user.device).text}"
        if not held(user):
            kind = user.operator.kind
            words += f" Without an arm on the device (operator.kind = {kind}) no bound is known."
        found.append(words)
    return found
