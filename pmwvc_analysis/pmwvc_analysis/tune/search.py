# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The search: filters and holds that are fit for the rate drop, and the best impedance of each. On
the strict channel, which has neither, one impedance, or one in free motion and one in contact.

The best impedance of a filter and a hold is found from their lag tau (a spring 2b/tau, a mass
b tau/2) and the noise of the encoder; the few choices that are left are rated by the exact model.
An impedance stays between the least that keeps a one-step-delay port passive (K T_VE + 2B <= b)
and a quarter of what the force loop itself stands at a matched port, b T_c/m = 2; and one step d
of an encoder to and fro passes the slew limit, 2 b d/T_c <= max_slew T_c.

The best choices are then simulated with the scenario's own hands, until one is stable there and
not limited by safety; else all of them are tried with a smaller impedance.
"""

import contextlib
import dataclasses
import itertools
import math
from typing import NamedTuple

import numpy as np

from pmwvc_analysis.budget.criterion import behind_counts
from pmwvc_analysis.prediction import lag, prediction
from pmwvc_analysis.tune import criteria
from pmwvc_analysis.tune.criteria import Choice, Rating
from pmwvc_core.controllers.library import record_of
from pmwvc_core.errors import PmwvcError
from pmwvc_core.master.count_bound import count_bound
from pmwvc_core.params import FilterParams
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.wave.impedance import first_axis
from pmwvc_core.wave.velocity_filter_design import chosen as velocity_filter

STEP = 1.5  # factor between the alternatives
TRIED = 3  # choices that are simulated at each impedance
HOLDS = ("foh", "zoh")
FOLLOWS = "b follows contact"  # on the strict channel
LEAST, FINE = 1.0, 200  # [N s/m], points of the impedance looked at
Key = tuple[str, str]  # filter, hold
Bounds = tuple[float, float]  # [N s/m]


class Proposal(NamedTuple):
    """The proposed choice, and others by name: as given, stiffer, lighter, other filters and
    holds; ``bounds`` are the impedances examined [N s/m].
    """

    best: Rating
    others: dict[str, Rating]
    bounds: Bounds


def propose(scenario: Scenario, *, live: bool = False) -> Proposal:
    """Return the best choice for a scenario and its neighbours; PmwvcError without waves, or where
    nothing found is stable, in the model or simulated.
    """
    record = record_of(scenario.controller)
    if not record.waves:
        raise PmwvcError(
            f"{scenario.name}: controller = {record.name}: impedance, filter and hold "
            "belong to waves; docs/controllers.md has the tuning rules of the others"
        )
    if record.linear != record.name:
        raise PmwvcError(
            f"{scenario.name}: controller = {record.name}: has no exact model to tune it by; "
            "tune controller = pmwvc, and check the result with 'pmwvc simulate'"
        )
    bounds, simulated = bounds_of(scenario), ""
    choices = choices_of(scenario, bounds, live=live)
    while choices:
        rows = {key: criteria.rated(scenario, one, live=live) for key, one in choices.items()}
        # those that are stable in the model: proved ones first, then by cost
        costs = {key: row.cost for key, row in rows.items() if row.cost is not None}
        best_first = sorted(
            costs, key=lambda key: (not rows[key].passive, round(costs[key], 3), key)
        )
        for key in best_first[:TRIED]:
            best = criteria.judged(scenario, rows[key])
            if best.simulated == criteria.STABLE:
                others = _others(scenario, best, rows, key, bounds, live=live)
                return Proposal(best, others, bounds)
            simulated = f" ('{best.simulated}' when simulated)"
        lower = ((key, one) for key, one in choices.items() if one.impedance > bounds[0])
        choices = {key: one.times(1.0 / STEP, bounds) for key, one in lower}
    raise PmwvcError(
        f"{scenario.name}: no impedance from {bounds[0]:.3g} N s/m up is stable with any filter, "
        f"in contact and in free motion{simulated}; make the environment softer or "
        "server.period_s shorter, give device.damping, take server.coupling = implicit where it "
        "is another, or a finer encoder"
    )


def choices_of(scenario: Scenario, bounds: Bounds, *, live: bool) -> dict[Key, Choice]:
    """Return every filter and hold with its best impedance."""
    found: dict[Key, Choice] = {}
    holds = (scenario.users[0].master.hold,) if scenario.strict else HOLDS
    for (name, one), hold in itertools.product(filters_of(scenario).items(), holds):
        found[name, hold] = best_impedance(scenario, one, hold, bounds, live=live)
    if scenario.strict:
        ((key, one_b),) = found.items()
        found[FOLLOWS, key[1]] = two_impedances(scenario, one_b, bounds, live=live)
    return found


def _others(
    scenario: Scenario,
    best: Rating,
    rows: dict[Key, Rating],
    chosen: Key,
    bounds: Bounds,
    *,
    live: bool,
) -> dict[str, Rating]:
    """Return what stands beside a proposal: the scenario as given, and one step each way."""
    user, master = scenario.users[0], scenario.users[0].master
    both = first_axis(user.impedance), master.filter, master.hold, master.contact_impedance
    given = Choice(*both, as_given=True)
    found = {"as given": criteria.judged(scenario, criteria.rated(scenario, given, live=live))}
    for label, factor in (("stiffer", STEP), ("lighter", 1.0 / STEP)):
        choice = best.choice.times(factor, bounds)
        if choice != best.choice:
            found[label] = criteria.rated(scenario, choice, live=live)
    for (name, hold), row in rows.items():
        if (name == chosen[0]) != (hold == chosen[1]):  # one of both differs
            found[name if scenario.strict else f"{name}, {hold}"] = row
    return found


def bounds_of(scenario: Scenario) -> Bounds:
    """Return the least and the largest impedance to look at [N s/m]."""
    step, coupled = criteria.velocity_step(scenario), scenario.coupling.least_impedance
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
    """Return the filters to choose from, by name: those that can be built at this tick, with the
    velocity filter there is, and let hardly any aliasing through.
    """
    user = scenario.users[0]
    master = user.master
    found = {"one b" if scenario.strict else "filter as given": master.filter}
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
    scenario: Scenario, one: FilterParams, hold: str, bounds: Bounds, *, live: bool
) -> Choice:
    """Return the impedance of least cost for a filter and a hold, from the lag of the link."""
    choice = Choice(bounds[0], one, hold)
    tau_s, free_kg = _felt_of(scenario, choice, live)
    return dataclasses.replace(choice, impedance=_cheapest(scenario, bounds, tau_s, free_kg))


def two_impedances(scenario: Scenario, choice: Choice, bounds: Bounds, *, live: bool) -> Choice:
    """Return the impedance in contact of least cost, where the object moves along, its mass shared
    by the users, and that in free motion whose mass b tau/2 is just not noticed beside device and
    arm: what is lighter feels no better. ``choice`` has one for both, which lies between.
    """
    tau_s, free_kg = _felt_of(scenario, choice, live)
    shared_kg = float(scenario.server.object_mass) / len(scenario.users)
    object_kg = shared_kg if scenario.environment.movable else math.inf
    touching = _cheapest(scenario, bounds, tau_s, free_kg + object_kg)
    unnoticed = 2.0 * free_kg * math.expm1(criteria.NOTICED) / tau_s
    light = min(max(unnoticed, bounds[0]), choice.impedance)
    return dataclasses.replace(choice, impedance=light, contact=max(touching, choice.impedance))


def _felt_of(scenario: Scenario, choice: Choice, live: bool) -> tuple[float, float]:
    """Return the lag of the link [s], and the mass of device and arm in front of it [kg]."""
    chosen = choice.applied(scenario)
    user = chosen.users[0]
    return lag.lag_s(user, chosen, live=live), float(user.device.mass) + float(user.operator.mass)


def _cheapest(scenario: Scenario, bounds: Bounds, tau_s: float, whole_kg: float) -> float:
    """Return the impedance of least cost behind a lag, beside so much mass in the hand."""
    b, stiffness = np.geomspace(*bounds, FINE), float(scenario.users[0].contact.contact_stiffness)
    softer = 1.0 / (1.0 + stiffness * tau_s / (2.0 * b))
    heavier = 1.0 + np.maximum(b * tau_s / 2.0, 0.0) / whole_kg
    noise = criteria.noise_n(scenario, b) if criteria.velocity_step(scenario) else 0.0
    costs = criteria.cost_of(np.where(softer > 0.0, softer, 1.0), heavier, noise)
    return float(b[int(np.argmin(costs))])
