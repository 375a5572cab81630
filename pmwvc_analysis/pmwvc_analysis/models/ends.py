# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Both ends of one run in the exact model: without limits and brakes, in contact all the time."""

import math
from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any, NamedTuple

from pmwvc_analysis.models.elements import lifted, stacked
from pmwvc_analysis.models.links import LinkTimes, UnderWay
from pmwvc_analysis.models.variation import changed
from pmwvc_core.controllers.plugged import PluggedLaw
from pmwvc_core.law.port.counts import resting_counts
from pmwvc_core.law.server.contacts import offset_of
from pmwvc_core.law.vectors import plus
from pmwvc_core.made.server import resting_server, server_params
from pmwvc_core.made.user import made_user
from pmwvc_core.plant.device import resting_device, simulated_params
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.server.contained import Contained

LEAST_S = 1e-9  # of a soft start
OFFSET = lifted(offset_of)


class Params(NamedTuple):
    """Parameters of all that is stepped: force loops, devices, and the server."""

    loops: tuple[Any, ...]
    devices: tuple[Any, ...]
    server: Any


class LoopState(NamedTuple):
    """State of all that is stepped, and each user's packets under way."""

    loops: tuple[Any, ...]
    devices: tuple[Any, ...]
    server: Any
    up: tuple[UnderWay, ...]
    down: tuple[UnderWay, ...]


def made(
    runs: Sequence[Scenario], lines: Sequence[LinkTimes], dof: int
) -> tuple[LoopState, Params]:
    """Return both ends of scenarios as one: numbers that differ are arrays ``(runs,)``."""
    kept: dict[tuple[int, ...], Any] = {}
    # With a position feedback, be it of no gain, where any run has one.
    fed = [
        any(user.master.position.is_on for user in of)
        for of in zip(*(run.users for run in runs), strict=True)
    ]
    found: tuple[LoopState, Params] = stacked([_made(run, lines, fed, dof, kept) for run in runs])
    return found


def _made(
    scenario: Scenario,
    lines: Sequence[LinkTimes],
    fed: Sequence[bool],
    dof: int,
    kept: dict[tuple[int, ...], Any],
) -> tuple[LoopState, Params]:
    """Return both ends of one run; those of users with the same parameters are made once."""
    server = scenario.server
    if not scenario.coupling.black_box and not scenario.environment.known:
        server = changed(server, environment="wall")  # a black box only
    of = SimpleNamespace(**vars(scenario) | {"dof": dof, "times": scenario.times})
    rest, ends, guests = (0.0,) * dof, [], []
    for index, (user, line) in enumerate(zip(scenario.users, lines, strict=True)):
        own = user.master, user.baseline, user.own, user.safety, user.device
        touching = _touching(user, fed[index])
        key = index, *map(id, own)
        if key not in kept:
            s, p = made_user(touching, of, answer_tick=line.answer.phase)
            device = simulated_params(user.device, scenario.tick_s)
            # With the parameters, so that their numbers stay those of this user.
            kept[key] = (*_opened(s, p), resting_device(rest, device), device, own)
        ends.append(kept[key][:4])
        guests += [touching] * len(line.ports)
    q = server_params(guests, of, server)
    at_server = resting_server(guests, of, q)
    states, params, devices, of_devices = zip(*ends, strict=True)
    none = ((),) * len(lines)
    q = q._replace(environment=_unlimited(q.environment))
    return LoopState(states, devices, at_server, none, none), Params(params, of_devices, q)


def _opened(s: Any, p: Any) -> tuple[Any, Any]:
    """Return a force loop without limits, with exact positions; its law may be a plug-in's."""
    far = {name: math.inf for name, limit in p.limits._asdict().items() if type(limit) is float}
    far |= {"soft_start_s": LEAST_S, "tick_s": p.limits.tick_s, "brakes": False}
    p = p._replace(limits=p.limits._replace(**far), arrivals=p.arrivals._replace(longest=math.inf))
    if isinstance(law := getattr(p.port, "law", None), PluggedLaw):
        p = p._replace(port=p.port._replace(law=law._replace(device=lifted(law.device))))
    if hasattr(s.port, "counts"):
        exact = tuple(resting_counts(x)._replace(step_m=0.0) for x in s.port.x)
        s = s._replace(port=s.port._replace(counts=exact, begun=True))
    return s, p


def _unlimited(e: Any) -> Any:
    """Return an environment without brakes; what a coupling raises is not contained."""
    if hasattr(e, "brakes"):
        e = e._replace(brakes=False)
    if isinstance(getattr(e, "laws", (None,))[0], PluggedLaw):
        return e._replace(laws=tuple(p._replace(avatar=lifted(p.avatar)) for p in e.laws))
    if isinstance(getattr(e, "coupling", None), Contained):
        return e._replace(coupling=e.coupling.law)
    return e


def _touching(user: User, fed: bool) -> User:
    """Return a user always in contact and with a local model; with feedback where ``fed``."""
    position, local = user.master.position, changed(user.master.local_model, acts="everywhere")
    if fed and not position.is_on:
        position = changed(position, gain=math.ulp(0.0))
    master = changed(user.master, local_model=local, position=position)
    return changed(user, master=master, contact=changed(user.contact, contact="bilateral"))


def followed(s: LoopState, lines: Sequence[LinkTimes], black_box: bool) -> LoopState:
    """Put avatars where contacts and object are; equal users are with the first of them."""
    server, environment = s.server, s.server.environment
    guests, ports, box = list(server.guests), list(environment.ports), environment.body
    body = box.environment.body if black_box else box
    inside: tuple[list[Any], ...] = ()
    if black_box:
        inside = list(box.environment.visitors), list(box.users)
    for first, *others in (line.ports for line in lines):
        contact = inside[0][first].contact if black_box else ports[first].avatar.contact
        x_s = plus(body.x, OFFSET(contact))
        ports[first] = ports[first]._replace(x_s=x_s)
        if black_box:
            inside[0][first] = inside[0][first]._replace(at=x_s)
            inside[1][first] = inside[1][first]._replace(x=x_s, f=ports[first].avatar.f)
        for each in (guests, ports, *inside):
            for other in others:
                each[other] = each[first]
    if black_box:
        visitors, users = map(tuple, inside)
        held = box.environment._replace(visitors=visitors)
        box = box._replace(x=body.x, xd=body.xd, environment=held, users=users)
    environment = environment._replace(ports=tuple(ports), body=box)
    return s._replace(server=server._replace(guests=tuple(guests), environment=environment))
