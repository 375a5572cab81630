# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The cost of slow presses for the loan of the position feedback, on the strict channel.

A press x(t) on a contact of stiffness K takes K tau (K/K_most - 1) times the integral of xd^2,
with K_most = sqrt(2b) K_p; nothing up to K_most. K_p is the largest that it adapts to. The press
named is a raised cosine of ``FORCE_N`` in ``PRESS_S``, for which that integral is pi^2 F^2/(2 K^2
T).

Equations: docs/theory.md 17.17.
"""

import math

from pmwvc_analysis.prediction.lag import lag_s
from pmwvc_core.law.position.error import ADAPTED
from pmwvc_core.law.position.feedback import MOST
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.wave.impedance import first_axis

FORCE_N, PRESS_S = 1.0, 2.5


def press_lines(user: User, scenario: Scenario, *, live: bool) -> list[str]:
    """Return in words what becomes of a user's loan in slow presses; nothing without one."""
    position = user.master.position
    lent_j = float(position.storage_j)
    if not (scenario.strict and position.is_on and lent_j > 0.0) or scenario.coupling.black_box:
        return []
    tau_s, b = lag_s(user, scenario, live=live), first_axis(user.impedance)
    if tau_s <= 0.0:  # its avatar leads by more than the waves lag: nothing is to be paid
        return []
    most = math.sqrt(2.0 * b) * float(position.gain)
    if position.adapts:
        most = MOST * ADAPTED * 2.0 * b / tau_s
    stiffness = float(user.contact.contact_stiffness)
    head = f"{user.name}: slow presses on the contact of {stiffness:.0f} N/m"
    if stiffness <= most:
        return [
            f"{head} leave a part of the loan of {1e3 * lent_j:.3g} mJ (up to {most:.0f} N/m)."
        ]
    taken_j = math.pi**2 * FORCE_N**2 * tau_s * (stiffness / most - 1.0)
    taken_j /= 2.0 * stiffness * PRESS_S
    return [
        f"{head} use the loan of {1e3 * lent_j:.3g} mJ up (beyond {most:.0f} N/m): one of "
        f"{FORCE_N:g} N in {PRESS_S:g} s takes {1e3 * taken_j:.2g} mJ, so it lasts for about "
        f"{lent_j / taken_j:.0f}; the device then stands ahead of its avatar again, and the port "
        "stays passive."
    ]
