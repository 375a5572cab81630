# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy that comes of an encoder's steps, on either channel.

**Plain channel.** With steps q the positions measured have the rounding error e, evenly spread
over q where a grip chatters over several counts. What the anti-aliasing filter H lets through of
the difference quotient (e_k - e_{k-1})/T_c is in the packets; the environment gets it:

    P = b q^2/(12 T_c^2) mean of |1 - 1/z|^2 |H|^2 over all frequencies

**Strict channel.** What the port of the hand releases is bounded by
:mod:`pmwvc_core.master.count_bound`, which needs a hand on the device. Whatever the bound says, a
scenario without a person is simulated for its first ``LONGEST_S``, judged by the true motion.

Equations: docs/theory.md 14.4.
"""

import dataclasses
import functools

import numpy as np

from pmwvc_analysis.budget.criterion import behind_counts, held
from pmwvc_analysis.budget.energy import declared, user_energies
from pmwvc_core.errors import PmwvcError
from pmwvc_core.master.count_bound import count_bound
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.simulation.session import simulate_one
from pmwvc_core.wave.filter_design import response
from pmwvc_core.wave.impedance import largest
from pmwvc_core.words import quantity

POINTS = 16384  # frequencies of a mean
LONGEST_S = 6.0
BY_PEOPLE = ("remote", "none")  # operators whose force is a person's
LEAST_J = 1e-6  # what every port is judged with


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
    """Return in words what the ports behind such encoders give out; nothing without one."""
    found = []
    duration_s = min(scenario.duration_s, LONGEST_S)
    for user in scenario.users:
        if not behind_counts(user, scenario):
            continue
        bound, kind = count_bound(user.master, user.device), user.operator.kind
        words = f"{user.name}: {bound.text}"
        if not held(user):
            words += f" Without an arm on the device (operator.kind = {kind}) no bound is known."
        given_j = None
        if user.device.is_simulated and kind not in BY_PEOPLE:
            given_j = _given_j(scenario, duration_s).get(user.name)
        if given_j is None:
            found.append(f"{words} This session is not simulated beforehand.")
            continue
        port = f"{words} Simulated for {duration_s:g} s, the hand port"
        released = f"{port} releases up to {quantity(given_j, 'J')}"
        if given_j <= LEAST_J:
            found.append(f"{port} is passive.")
        elif bound.holds and held(user) and given_j <= bound.given_j:
            found.append(f"{released}, within that bound.")
        else:
            found.append(
                f"Warning: {released} more than it received. A velocity of the device's own, a "
                "finer encoder or a smaller master.impedance gives less."
            )
    return found


@functools.lru_cache(maxsize=4)
def _given_j(scenario: Scenario, duration_s: float) -> dict[str, float]:
    """Return what every hand port gave out beyond what it took in and its controller was lent [J];
    none where the scenario cannot be simulated.
    """
    short = dataclasses.replace(scenario, duration_s=duration_s)
    try:
        energies = user_energies(simulate_one(short), short)
    except PmwvcError:  # a file or plug-in that a recorded session had
        return {}
    lent_j = {user.name: declared(short, user).controller_j for user in short.users}
    return {each.name: -each.joint.minimum_j - lent_j[each.name] for each in energies}
