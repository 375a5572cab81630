# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The laws of the server made from parameters, at rest, and what changes in flight."""

import math
from collections import deque
from collections.abc import Sequence
from operator import call as at_once
from typing import Any

import numpy as np

from pmwvc_core.controllers.library import is_strict, record_of
from pmwvc_core.controllers.plugged import Kept
from pmwvc_core.errors import ParameterError
from pmwvc_core.law.black_box.black_box import Accounts, BlackBoxParams, BoxState
from pmwvc_core.law.black_box.compensations import Terms
from pmwvc_core.law.black_box.secant import Seen, resting_secant
from pmwvc_core.law.channel.arrivals import start_of
from pmwvc_core.law.channel.constants import SETTLE_S
from pmwvc_core.law.channel.packet import Packing
from pmwvc_core.law.motion import Body, BodyLaw, body_law, changed_body
from pmwvc_core.law.safety.brakes import AvatarBrake, resting_brake
from pmwvc_core.law.server.contacts import Avatar, Contact
from pmwvc_core.law.server.coupling import Implicit, weights
from pmwvc_core.law.server.server_port import EnvironmentParams, SharedScene, UserPort
from pmwvc_core.law.server.springs import ContactLaw, Spring
from pmwvc_core.law.server_step import ABSENT, Guest, GuestParams, Server, ServerStepParams
from pmwvc_core.law.wave.following import FREE
from pmwvc_core.law.wave.wave import Rows
from pmwvc_core.law.without_waves.ends import AvatarEndParams
from pmwvc_core.made.user import arrivals_params, end_law, groups_of, packing_params, values_of
from pmwvc_core.made.waves import made_impedance
from pmwvc_core.numeric import Array
from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.params.ports import matrix_of
from pmwvc_core.params.server import KNOWN
from pmwvc_core.plugins import Faults, refused
from pmwvc_core.scenario import scenario as scenarios
from pmwvc_core.server.black_box import BlackBox, Call, EnvironmentSetup, Outside, rows_of
from pmwvc_core.server.contained import Contained
from pmwvc_core.server.couplings import COMPENSATIONS, COUPLINGS
from pmwvc_core.server.environments import environment_of
from pmwvc_core.server.turned import Turned
from pmwvc_core.wave import impedance as impedances
from pmwvc_core.wave.impedance import MatrixImpedance


def coupling_of(server: ServerParams, faults: Faults | None = None) -> Any:
    """Return what closes the algebraic loop, that of another package contained, which counts its
    ``faults``; ParameterError where it cannot make its law (with the reason).
    """
    record = COUPLINGS.of(server.coupling)
    assert record.law is not None
    with refused(f"server.coupling = {record.name!r}"):
        law = record.law(*weights(server.integrator, server.period_s))
    if record.name not in COUPLINGS.library:
        return Contained(law, Implicit(0), faults or Faults("server.coupling", record.name))
    return law


def object_of(server: ServerParams) -> BodyLaw:
    """Return the law of an object; ParameterError where it is known as a black box only."""
    environment = environment_of(server.environment)
    if not environment.known:
        raise ParameterError(
            f"server.environment = {server.environment!r}: needs controller = pmwvc with "
            f"server.coupling = unknown; here there are {', '.join(KNOWN)}"
        )
    mass = server.object_mass if environment.movable else math.inf
    return body_law(mass, server.object_damping, server.period_s)


def contact_of(contact: ContactParams, *, side: int, size: float, axes: int) -> Contact:
    """Return the contact of an avatar that has not joined."""
    face = 0.5 * side * size
    law = ContactLaw(
        contact.contact_stiffness, contact.contact_damping, -float(side), face, contact.gap_m
    )
    first = Spring(0.0, face, True) if contact.grips else Spring(0.0, 0.0, False)
    return Contact(law, (first,) + (Spring(0.0, 0.0, False),) * (axes - 1))


def server_params(
    users: Sequence["scenarios.User"], session: Any, server: ServerParams,
    faults: Faults | None = None,
) -> ServerStepParams:  # fmt: skip
    """Return the parameters of the server's step; ``session`` has controller, channel, axes and
    times (a scenario, or what a node was given), ``faults`` counts those of a coupling.
    """
    record, brakes = record_of(session.controller), brakes_of(users, session)
    times, guests = session.times, []
    rules = times.timeout_s, SETTLE_S, server.store_j
    for user in users:
        arrivals = arrivals_params(session, user.server_impedance, *rules)
        most = user.master.rises if arrivals.plays_on else 1.0
        guests.append(GuestParams(arrivals, packing_params(user.contact.deadband), most))
    environment: Any
    if record.avatar is not None or record.law is not None:
        ends = (end_law(record, values_of(user, record), user.master.tick_s) for user in users)
        environment = AvatarEndParams(tuple(ends), object_of(server))
    elif COUPLINGS.of(server.coupling).black_box:
        law, of_environment = None, environment_of(server.environment)
        if of_environment.made:
            _, law = of_environment.made(server, len(users), session.dof)
        sloped, moves = of_environment.sloped, weights(server.integrator, server.period_s)
        identity = rows_of(np.eye(session.dof))
        wall, h = body_law(math.inf, 0.0, server.period_s), server.period_s
        treated = Terms(h, h * server.allowance_w, server.allowance_j, server.tank_cap_j)
        environment = BlackBoxParams(
            law, treated, wall, brakes, *moves, sloped,
            server.learns and not sloped, identity,
        )  # fmt: skip
    else:
        environment = EnvironmentParams(coupling_of(server, faults), object_of(server), brakes)
    return ServerStepParams(
        tuple(guests), environment, server.period_s, times.release_s, times.soft_start_s
    )


def matrices_given(users: Sequence["scenarios.User"]) -> list[Array]:
    """Return the impedance matrices of all ends, which are fixed."""
    ends = (end for user in users for end in (user.master, user.contact))
    return [matrix_of(end.impedance_matrix) for end in ends if end.impedance_matrix.strip()]


def brakes_of(users: Sequence["scenarios.User"], session: Any) -> Rows:
    """Return 1 for each axis of each brake of an avatar, else 0: none off the strict channel."""
    strict = is_strict(session.controller, session.channel)
    apart = strict and all(np.allclose(b[:3, 3:], 0.0) for b in matrices_given(users))
    return groups_of(session.dof) if apart else ((1.0 * strict,) * session.dof,)


def port_impedance(b: Any, users: Sequence["scenarios.User"], session: Any) -> Any:
    """Return the impedance of a port for the laws: a matrix also of a number, if any is one."""
    matrix = matrices_given(users) or len(brakes_of(users, session)) > 1
    if matrix and not isinstance(b, MatrixImpedance):
        b = MatrixImpedance(np.full(session.dof, b), np.eye(session.dof))
    return made_impedance(b)


def changed_server(s: SharedScene, p: ServerStepParams, q: ServerStepParams) -> SharedScene:
    """Go on with other parameters of object and coupling, from forces and velocities as they are;
    no energy comes or goes. ``p`` are the parameters until here, ``q`` those from here on. A black
    box keeps its own.
    """
    if isinstance(s.body, BoxState):
        return s
    return s._replace(body=changed_body(s.body, p.environment.body, q.environment.body))


def made_outside(users: Sequence["scenarios.User"], session: Any) -> BlackBox:
    """Return an environment that is an object; ParameterError where a session does not fit it."""
    server, axes, name = session.server, session.dof, session.server.environment
    own = getattr(session.own, name, None)
    sides, contacts = zip(*((user.side, user.contact) for user in users), strict=True)
    b = [port_impedance(user.server_impedance, users, session).b for user in users]
    setup = EnvironmentSetup(axes, server.period_s, sides, server, contacts, own, b)
    outside = environment_of(name).outside
    assert outside is not None
    environment: BlackBox = outside(setup)
    if hasattr(environment, "meet"):
        where = f"server.environment = {name!r} answers an impedance"
        if server.integrator != "backward_euler":
            raise ParameterError(f"{where}: set server.integrator = backward_euler")
        if isinstance(b[0], tuple) and not getattr(environment, "couples", False):
            wanted = "remove impedance_matrix; six axes with channel = strict need couples = True"
            raise ParameterError(f"{where}, one number for all axes: {wanted}")
    return environment


def _resting_box(users: Sequence["scenarios.User"], session: Any, call: Call) -> BoxState:
    """Return a black box that nobody touches; ``call`` is how one of another package is asked."""
    axes, server, name = session.dof, session.server, session.server.environment
    rest = (0.0,) * axes
    record = environment_of(name)
    if record.made:
        state, _ = record.made(server, len(users), axes)
    else:
        faults, absent = Faults("server.environment", name), (False,) * len(users)
        environment, places = made_outside(users, session), np.zeros((len(users), axes))
        turned = Turned(places.shape, server)
        state = Outside(environment, deque(), call, faults, absent, places, turned)
    least = (float(impedances.smallest(user.server_impedance)) for user in users)
    seen = tuple(Seen(resting_secant(rest, b / server.period_s, False), 0, rest) for b in least)
    compensation = COMPENSATIONS.of(server.compensation).rest(len(users))
    return BoxState(rest, rest, state, compensation, seen, 0.0, -1.0, Accounts(0.0, 0.0, 0.0, 0.0))


def resting_server(
    users: Sequence["scenarios.User"], session: Any, p: ServerStepParams, call: Call = at_once
) -> Server:
    """Return the server with no user present. Environments of other packages have their parameters
    in ``session.own``, by their names, and ``call`` is how they are asked.
    """
    axes, record, brakes = session.dof, record_of(session.controller), brakes_of(users, session)
    rest, (up, down) = (0.0,) * axes, record.extra(axes)
    ports, guests, size_m = [], [], session.server.object_size_m
    for user, guest in zip(users, p.guests, strict=True):
        kept: Any = AvatarBrake((resting_brake(rest),) * len(brakes), rest, 0.0)
        if record.avatar is not None or record.law is not None:
            kept = record.avatar_rest(values_of(user, record), axes)
        if record.avatar is not None:
            kept = Kept(kept, kept)
        b = port_impedance(user.server_impedance, users, session)
        contact = contact_of(user.contact, side=user.side, size=size_m, axes=axes)
        avatar = Avatar(False, b, rest, rest, rest, contact, rest)
        sums, extra = (0.0, 0.0, -1.0), (0.0,) * down
        ports.append(UserPort(avatar, kept, rest, rest, rest, *sums, extra, 0))
        rules = guest.arrivals
        arrivals = start_of(rules.plays_on, axes, rules.timeout_s, user.master.frame_s)
        guests.append(Guest(ABSENT, False, arrivals, Packing(rest, rest, rest), (0.0,) * up, FREE))
    body: Any = Body(rest, rest)
    if isinstance(p.environment, BlackBoxParams):
        body = _resting_box(users, session, call)
    return Server(tuple(guests), SharedScene(tuple(ports), body, 0.0, 0), math.inf)
