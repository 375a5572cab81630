# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The candidates of a search: bounds of the impedance, filters that are fit for the rate drop, and
the best impedance of each by the lag of the link.

The link is a spring 2b/tau and a mass b tau/2. An impedance stays between the least that keeps a
one-step-delay port passive (K T_VE + 2B <= b) and a quarter of what the force loop itself stands
at a matched port, b T_c/m = 2; and one step d of an encoder to and fro passes the slew limit,
2 b d/T_c <= max_slew T_c.
"""

import contextlib
import dataclasses

import numpy as np

from pmwvc_analysis.budget.criterion import behind_counts
from pmwvc_analysis.prediction import lag, prediction
from pmwvc_analysis.tune.criteria import Choice, cost_of, noise_n, velocity_step
from pmwvc_core.errors import PmwvcError
from pmwvc_core.master.count_bound import count_bound
from pmwvc_core.params import FilterParams
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.wave.design.velocity_filter_design import chosen as velocity_filter

LEAST, FINE = 1.0, 200  # [N s/m], points of the impedance looked at


def bounds_of(scenario: Scenario) -> tuple[float, float]:
    """Return the least and the largest impedance to look at [N s/m]."""
    step, coupled = velocity_step(scenario), scenario.coupling.least_impedance
    least, most = [LEAST], []
    for user in scenario.users:
        tick_s = float(user.master.tick_s)
        most.append(0.5 * float(user.device.mass) / tick_s)
        if step is not None:
            most.append(0.5 * float(user.safety.max_slew) * tick_s / step)
        if behind_counts(user, scenario):
            most.append(count_bound(user.master, user.device).largest_impedance)
        if coupled is not None:
            least.append(coupled(scenario.server, user.contact))
    return min(max(least), min(most)), min(most)


def filters_of(scenario: Scenario) -> dict[str, FilterParams]:
    """Return the filters to choose from, by what they are called in the answer: those that can be
    built at this tick, with the velocity filter there is, and let hardly any aliasing through.
    """
    user = scenario.users[0]
    master = user.master
    found = {"filter as given": master.filter}
    half_hz = 0.5 / master.frame_s  # half the packet rate
    others = {
        "integrate and dump": FilterParams(kind="integrate_and_dump"),
        "first order, 0.1 of the packet rate": FilterParams(
            kind="first_order", cutoff_hz=round(0.2 * half_hz, 3)
        ),
        "Butterworth up to half the packet rate": FilterParams(
            kind="butterworth", pass_hz=half_hz, stop_hz=2.0 * half_hz
        ),
    }
    for name, one in others.items() if not scenario.strict else ():
        if one != master.filter:
            own = dataclasses.replace(master, filter=one)
            with contextlib.suppress(PmwvcError):
                if master.velocity_filter.is_on:
                    velocity_filter(own)
                gain = prediction.aliasing_gain(dataclasses.replace(user, master=own))
                if gain <= prediction.ALIASING_BOUND:
                    found[name] = one
    return found


def best_impedance(
    scenario: Scenario, one: FilterParams, hold: str, bounds: tuple[float, float], *, live: bool
) -> Choice:
    """Return the impedance of least cost for a filter and a hold, from the lag of the link."""
    b = np.geomspace(*bounds, FINE) if bounds[0] < bounds[1] else np.array([bounds[1]])
    chosen = Choice(float(b[0]), one, hold).applied(scenario)
    user = chosen.users[0]
    tau_s = lag.lag_s(user, chosen, live=live)
    contact = float(user.contact.contact_stiffness)
    whole = float(user.device.mass) + float(user.operator.mass)
    softer = 1.0 / (1.0 + contact * tau_s / (2.0 * b))
    heavier = 1.0 + np.maximum(b * tau_s / 2.0, 0.0) / whole
    noise = noise_n(scenario, b) if velocity_step(scenario) else 0.0
    costs = cost_of(np.where(softer > 0.0, softer, 1.0), heavier, noise)
    return Choice(float(b[int(np.argmin(costs))]), one, hold)
