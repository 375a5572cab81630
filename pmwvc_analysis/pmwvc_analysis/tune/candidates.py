# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The candidates of a search: bounds of the impedance, filters that are fit for the rate drop, and
the best impedance of each by the lag of the link.

The link is a spring 2b/tau and a mass b tau/2. An impedance stays between the least that keeps a
one-step-delay port passive (K T_VE + 2B <= b) and a quarter of what the force loop itself stands
at a matched port, b T_c/m = 2; and one step d of an encoder to and fro passes the slew limit,
2 b d/T_c <= max_slew T_c.
"""

import dataclasses

import numpy as np

from pmwvc_analysis.budget.counts import behind_counts
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
    largest = min(
        0.5 * float(user.device.mass) / float(user.master.tick_s) for user in scenario.users
    )
    step = velocity_step(scenario)
    if step is not None:
        passes = min(
            float(user.safety.max_slew) * float(user.master.tick_s) for user in scenario.users
        )
        largest = min(largest, 0.5 * passes / step)
    for user in scenario.users:
        if behind_counts(user, scenario):
            largest = min(largest, count_bound(user.master, user.device).largest_impedance)
    least = LEAST
    bound = scenario.coupling.least_impedance
    if bound is not None:
        least = max(bound(scenario.server, user.contact) for user in scenario.users)
    return min(max(least, LEAST), largest), largest


def filters_of(scenario: Scenario) -> dict[str, FilterParams]:
    """Return the filters to choose from, by what they are called in the answer."""
    master = scenario.users[0].master
    if scenario.strict:
        return {"filter as given": master.filter}
    half_hz = 0.5 / master.frame_s  # half the packet rate
    found = {
        "integrate and dump": FilterParams(kind="integrate_and_dump"),
        "first order, 0.1 of the packet rate": FilterParams(
            kind="first_order", cutoff_hz=round(0.2 * half_hz, 3)
        ),
        "Butterworth up to half the packet rate": FilterParams(
            kind="butterworth", pass_hz=half_hz, stop_hz=2.0 * half_hz
        ),
    }
    return {"filter as given": master.filter} | {
        name: one for name, one in found.items() if one != master.filter
    }


def is_fit(scenario: Scenario, one: FilterParams) -> bool:
    """Tell whether a filter can be built at this tick, with the velocity filter there is, and
    lets hardly any aliasing through.
    """
    user = scenario.users[0]
    master = dataclasses.replace(user.master, filter=one)
    try:
        if master.velocity_filter.is_on:
            velocity_filter(master)
        gain = prediction.aliasing_gain(dataclasses.replace(user, master=master))
    except PmwvcError:
        return False
    return one == user.master.filter or gain <= prediction.ALIASING_BOUND


def best_impedance(
    scenario: Scenario, one: FilterParams, hold: str, bounds: tuple[float, float], *, live: bool
) -> Choice:
    """Return the impedance of least cost for a filter and a hold, from the lag of the link."""
    grid = np.geomspace(*bounds, FINE) if bounds[0] < bounds[1] else np.array([bounds[1]])
    chosen = Choice(float(grid[0]), one, hold).applied(scenario)
    user = chosen.users[0]
    tau_s = lag.lag_s(user, chosen, live=live)
    contact, device = float(user.contact.contact_stiffness), float(user.device.mass)
    whole = device + float(user.operator.mass)
    costs = []
    for impedance in grid:
        rendered = lag.series_stiffness(contact, float(impedance), tau_s)
        heavier = (whole + max(impedance * tau_s / 2.0, 0.0)) / whole
        noise = noise_n(scenario, float(impedance)) if velocity_step(scenario) else 0.0
        costs.append(cost_of(rendered / contact if rendered > 0.0 else 1.0, heavier, noise))
    return Choice(float(grid[int(np.argmin(costs))]), one, hold)
