# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Both ends of one run in the exact model: without limits and brakes, in contact all the time."""

import dataclasses
import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from pmwvc_analysis.models.elements import lifted, stacked
from pmwvc_analysis.models.links import Line
from pmwvc_analysis.models.variation import runs_of
from pmwvc_core.controllers.plugged_ends import PluggedParams, PluggedServerParams
from pmwvc_core.law.channel.arrivals import arrivals_of
from pmwvc_core.law.port.counts import resting_counts
from pmwvc_core.law.port.master import port_opened
from pmwvc_core.made.server import resting_server, server_params
from pmwvc_core.made.user import resting_user, user_params
from pmwvc_core.params.user import server_times
from pmwvc_core.plant.device import resting_device, simulated_params
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.server.couplings.contained import Contained

LEAST_S = 1e-9  # of a soft start


class Ends(NamedTuple):
    """All that is stepped: force loops, devices, and the server, by state or by parameters."""

    loops: tuple[Any, ...]
    devices: tuple[Any, ...]
    server: Any


def made(scenario: Scenario, lines: Sequence[Line], dof: int) -> tuple[Ends, Ends]:
    """Return both ends of a scenario whose numbers may be columns ``(runs, 1)``."""
    server = scenario.server
    if not scenario.coupling.black_box and not scenario.environment.known:
        server = dataclasses.replace(server, environment="wall")  # a black box only
    users = tuple(map(two_sided, scenario.users))
    modelled = dataclasses.replace(scenario, users=users, server=server)
    kept: dict[tuple[int, ...], Any] = {}
    found: tuple[Ends, Ends] = stacked([_made(run, lines, dof, kept) for run in runs_of(modelled)])
    return found


def _made(
    scenario: Scenario, lines: Sequence[Line], dof: int, kept: dict[tuple[int, ...], Any]
) -> tuple[Ends, Ends]:
    """Return both ends of one run; those of users with the same parameters are made once."""
    server, controller = scenario.server, scenario.controller
    of: dict[str, Any] = {"controller": controller, "channel": scenario.channel}
    rest, loops = (0.0,) * dof, []
    for index, (user, line) in enumerate(zip(scenario.users, lines, strict=True)):
        own = user.master, user.baseline, user.own, user.safety, user.device
        key = index, *map(id, own)
        if key not in kept:
            fed = _fed_back(user, line.user.master.position.is_on)
            p = user_params(fed, packet_s=server.period_s, answer_tick=line.answer.phase, **of)
            packet_s = server.period_s
            s = resting_user(fed, p, controller=controller, axes=dof, packet_s=packet_s)
            s = s._replace(arrivals=arrivals_of(s.arrivals, rest), port=port_opened(s.port))
            device = simulated_params(user.device, scenario.tick_s)
            # With the parameters, so that their numbers stay those of this user.
            kept[key] = (*_opened(s, p), resting_device(rest, device), device, own)
        loops.append(kept[key][:4])
    guests = [user for user, line in zip(scenario.users, lines, strict=True) for _ in line.ports]
    times = server_times(user.safety for user in scenario.users)
    q = server_params(guests, server=server, times=times, axes=dof, **of)
    at_server = resting_server(guests, q, controller=controller, server=server, axes=dof)
    if hasattr(q.environment, "brakes"):
        q = q._replace(environment=q.environment._replace(brakes=False))
    present = [g._replace(arrivals=arrivals_of(g.arrivals, rest)) for g in at_server.guests]
    at_server = at_server._replace(guests=tuple(present))
    states, params, devices, of_devices = zip(*loops, strict=True)
    return Ends(states, devices, at_server), Ends(
        tuple(map(_from_outside, params)), of_devices, _at_server_from_outside(q)
    )


def _from_outside(p: Any) -> Any:
    """Return a force loop whose law of another package takes elements, too."""
    if not isinstance(p.port, PluggedParams):
        return p
    return p._replace(port=p.port._replace(device=lifted(p.port.device)))


def _at_server_from_outside(q: Any) -> Any:
    """Return a server likewise; what a coupling raises is not contained."""
    e = q.environment
    if isinstance(e, PluggedServerParams):
        e = e._replace(avatar=lifted(e.avatar))
    elif isinstance(getattr(e, "coupling", None), Contained):
        e = e._replace(coupling=e.coupling.law)
    return q._replace(environment=e)


def _opened(s: Any, p: Any) -> tuple[Any, Any]:
    """Return a force loop without limits, which takes positions as exact."""
    limits = p.limits
    far = {name: math.inf for name, limit in limits._asdict().items() if type(limit) is float}
    limits = limits._replace(**far | {"soft_start_s": LEAST_S, "tick_s": limits.tick_s})
    port = s.port
    if hasattr(port, "counts"):
        exact = tuple(resting_counts(x)._replace(step_m=0.0) for x in port.x)
        port = port._replace(counts=exact, begun=True)
    arrivals = p.arrivals._replace(longest=math.inf)
    return s._replace(port=port), p._replace(
        limits=limits._replace(brakes=False), arrivals=arrivals
    )


def _fed_back(user: User, anywhere: bool) -> User:
    """Return a user with a position feedback, be it of no gain, where any run has one."""
    if not anywhere or user.master.position.is_on:
        return user
    position = dataclasses.replace(user.master.position, gain=math.ulp(0.0))
    return dataclasses.replace(user, master=dataclasses.replace(user.master, position=position))


def two_sided(user: User) -> User:
    """Return a user who is in contact, and whose local model is there, all the time."""
    local = dataclasses.replace(user.master.local_model, acts="everywhere")
    master = dataclasses.replace(user.master, local_model=local)
    contact = dataclasses.replace(user.contact, contact="bilateral")
    return dataclasses.replace(user, master=master, contact=contact)
