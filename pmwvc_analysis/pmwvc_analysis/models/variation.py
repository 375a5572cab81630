# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Scenarios with other numbers, which are stepped side by side where they do not differ in what
decides when things happen (delays, periods, counts, names); and both ends of one as the exact
model has them: without limits, in contact all the time.
"""

import functools
import itertools
import math
from types import SimpleNamespace
from typing import Any, TypeVar

from pmwvc_analysis.models.links import LinkWay
from pmwvc_core.law.channel.arrivals import StrictArrivals
from pmwvc_core.law.channel.pace import NEW, Pace, pace_arrive, pace_step
from pmwvc_core.law.channel.playout import add
from pmwvc_core.law.port.counts import resting_counts
from pmwvc_core.law.vectors import zero
from pmwvc_core.made.server import resting_server, server_params
from pmwvc_core.made.user import made_user
from pmwvc_core.plant.device import resting_device, simulated_params
from pmwvc_core.scenario.names import resolved, spec_of
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.server.contained import Contained

AMPLE_J = 1e3  # more than any wave of the model needs, so no account ever binds
LEAST_S = 1e-9  # of a soft start
SETTLED_S = 100.0  # at most: many times as long as the lag takes to follow
KEPT = ("tick_s", "brake_stiffness")  # of the limits
TIMES = ("delay_s", "tick_s", "period_s")  # numbers that decide when things happen
T = TypeVar("T")


def stackable(name: str) -> bool:
    """Tell whether a parameter may differ side by side; ScenarioError where there is none."""
    group, _, leaf = resolved(name)[1][0].rpartition(".")
    return bool(group) and spec_of(name).kind is float and leaf not in TIMES


def changed(parameters: T, **values: Any) -> T:
    """Return parameters with other values, which need no check."""
    found = object.__new__(type(parameters))
    vars(found).update(vars(parameters) | values)
    return found


def with_stiffness(scenario: Scenario, stiffness: float) -> Scenario:
    """Return the scenario with another stiffness [N/m] of the stiffest contact, the others in
    proportion.
    """
    values = [float(user.contact.contact_stiffness) for user in scenario.users]
    users, top = [], max(values)
    for user, value in zip(scenario.users, values, strict=True):
        own = float(stiffness) * (value / top if top > 0.0 else 1.0)
        users.append(changed(user, contact=changed(user.contact, contact_stiffness=own)))
    return changed(scenario, users=tuple(users))


def user_at_rest(scenario: Scenario, dof: int, answer_tick: int, fed: bool) -> tuple[Any, Any]:
    """Return state and parameters of the first user's force loop and device, with exact positions;
    with a position feedback, be it of no gain, where ``fed``.
    """
    user = _touching(scenario.users[0])
    if fed and not user.master.position.is_on:
        position = changed(user.master.position, gain=math.ulp(0.0))
        user = changed(user, master=changed(user.master, position=position))
    s, p = made_user(user, _session(scenario, dof), answer_tick=answer_tick)
    limits = p.limits._asdict()
    far: dict[str, Any] = {name: math.inf for name in limits if type(limits[name]) is float}
    kept = {name: limits[name] for name in KEPT}
    far |= kept | {"soft_start_s": LEAST_S, "brakes": False}
    p = p._replace(limits=p.limits._replace(**far), arrivals=p.arrivals._replace(longest=math.inf))
    if hasattr(s.port, "counts"):
        exact = tuple(resting_counts(x)._replace(step_m=0.0) for x in s.port.x)
        s = s._replace(port=s.port._replace(counts=exact, begun=True, node_j=AMPLE_J))
    device = simulated_params(user.device, scenario.tick_s)
    return (s, resting_device((0.0,) * dof, device)), (p, device)


def server_at_rest(scenario: Scenario, dof: int) -> tuple[Any, Any]:
    """Return state and parameters of the server, without brakes; what a coupling raises is not
    contained.
    """
    server, session = scenario.server, _session(scenario, dof)
    if not scenario.coupling.black_box and not scenario.environment.known:
        server = changed(server, environment="wall")  # a black box only
    guests = list(map(_touching, scenario.users))
    p = server_params(guests, session, server)
    s, e = resting_server(guests, session, p), p.environment
    if hasattr(e, "brakes"):
        e = e._replace(brakes=((0.0,) * dof,) * len(e.brakes))
    if isinstance(getattr(e, "coupling", None), Contained):
        e = e._replace(coupling=e.coupling.law)
    return s, p._replace(environment=e)


def _session(scenario: Scenario, dof: int) -> Any:
    """Return the scenario with the axes of the model, which may be too few for it."""
    return SimpleNamespace(**vars(scenario) | {"dof": dof, "times": scenario.times})


def _touching(user: User) -> User:
    """Return a user always in contact and with a local model."""
    user = user.in_contact
    local = changed(user.master.local_model, acts="everywhere")
    contact = changed(user.contact, contact="bilateral")
    return changed(user, master=changed(user.master, local_model=local), contact=contact)


def sums_anew(s: Any) -> Any:
    """Let the sums that a strict receiver believes begin at zero."""
    arrivals = s.arrivals
    if not isinstance(arrivals, StrictArrivals):
        return s
    counting = arrivals.counting
    counting = counting._replace(integral=zero(counting.integral), energy_j=0.0)
    return s._replace(arrivals=arrivals._replace(counting=counting))


def with_pace(s: Any, pace: Pace, store_s: float) -> Any:
    """Return a receiver with a clock that has settled, and so much of zeros in store [s]."""
    playout = s.arrivals.playout
    stored = add(playout, zero(playout.undelivered), 0.0, store_s, 0.0)
    return s._replace(arrivals=s.arrivals._replace(playout=stored._replace(pace=pace)))


@functools.lru_cache(maxsize=4096)
def settled_pace(way: LinkWay, tick_s: float) -> Pace:
    """Return the settled clock of a receiver where a hyperperiod begins."""
    sent, looked = way.sent, way.looked
    ticks, pace, before = math.lcm(sent.period, looked.period), NEW, None
    arrival = (sent.phase + way.delay) % sent.period
    end = ticks * math.ceil(SETTLED_S / (ticks * tick_s))
    looks = iter(range(looked.phase, end, looked.period))
    while pace.burst_s > 0.0 or pace != before:
        before = pace
        for look in itertools.islice(looks, ticks // looked.period):
            while arrival <= look:
                pace = pace_arrive(pace, sent.period * tick_s)
                arrival += sent.period
            if arrival >= sent.period:
                pace, _, _ = pace_step(pace, looked.period * tick_s)
    return pace
