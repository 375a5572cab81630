# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The laws of the server made from parameters: what they start from, and what they go by."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from pmwvc_core.controllers.library import is_strict
from pmwvc_core.law.black_box.black_box import BlackBoxParams
from pmwvc_core.law.channel.arrivals import start_of
from pmwvc_core.law.channel.packing import packing_params, resting_packing
from pmwvc_core.law.safety.avatar_brake import RETURN_S as AVATAR_LETS_GO_S
from pmwvc_core.law.safety.avatar_brake import AvatarBrake
from pmwvc_core.law.safety.brake_force import resting_brake
from pmwvc_core.law.server.avatar import Avatar
from pmwvc_core.law.server.body import Body, BodyLaw, body_law, wall_law
from pmwvc_core.law.server.contacts import Contact, ContactLaw, Spring
from pmwvc_core.law.server.implicit import Implicit
from pmwvc_core.law.server.implicit_coupled import ImplicitCoupled
from pmwvc_core.law.server.sampled import OneFrameLate, OneStepDelay, Unwrapped, weights
from pmwvc_core.law.server.server_port import Environment, EnvironmentParams, Sums, UserPort
from pmwvc_core.law.server_step import ABSENT, Guest, GuestParams, Server, ServerStepParams
from pmwvc_core.law.without_waves.avatar_end import AvatarEndParams
from pmwvc_core.made.black_box import black_box_params, is_made, resting_box
from pmwvc_core.made.user import arrivals_params
from pmwvc_core.made.waves import made_impedance
from pmwvc_core.made.without_waves import CONTROLLERS
from pmwvc_core.params import ContactParams, MasterParams, ServerParams
from pmwvc_core.params.user import ServerTimes
from pmwvc_core.scenario import scenario as scenarios
from pmwvc_core.wave.impedance import Impedance, MatrixImpedance, impedance_of

WAVES = "pmwvc"  # the controller
UNKNOWN = "unknown"  # the coupling of black boxes
COUPLINGS: Mapping[str, Callable[[float, float], Any]] = {
    "implicit": lambda old_s, new_s: Implicit(0),
    "one_frame_late": lambda old_s, new_s: OneFrameLate(0),
    "one_step_delay": OneStepDelay,
    "unwrapped": Unwrapped,
}
OBJECTS: Mapping[str, Callable[[ServerParams], BodyLaw]] = {
    "cube": lambda server: body_law(server.object_mass, server.object_damping, server.period_s),
    "wall": lambda server: wall_law(server.period_s),
}


def coupling_of(server: ServerParams) -> Any:
    """Return what closes the algebraic loop."""
    return COUPLINGS[server.coupling](*weights(server.integrator, server.period_s))


def contact_of(contact: ContactParams, *, side: int, size: float, axes: int) -> Contact:
    """Return the contact of an avatar that has not joined."""
    face, grips = 0.5 * side * size, contact.grips
    law = ContactLaw(
        contact.contact_stiffness, contact.contact_damping, -float(side), face, contact.gap_m
    )
    first = Spring(0.0, face, True, False) if grips else Spring(0.0, 0.0, False, False)
    across = Spring(0.0, 0.0, False, False)
    return Contact(law, grips, (first,) + (across,) * (axes - 1))


def are_made(scenario: "scenarios.Scenario") -> bool:
    """Tell whether there are laws for all that a scenario consists of."""
    controller = scenario.controller
    return is_server_made(controller, scenario.server) and all(
        is_user_made(controller, user.master) for user in scenario.users
    )


def is_user_made(controller: str, master: MasterParams) -> bool:
    """Tell whether there are laws for a user's end: none for plug-ins, nor for a filter bank
    behind an impedance that couples the axes.
    """
    if controller != WAVES:
        return controller in CONTROLLERS
    coupled = isinstance(impedance_of(master), MatrixImpedance)
    return not (master.bank.is_on and (master.local_model.is_plugin or coupled))


def is_server_made(controller: str, server: ServerParams) -> bool:
    """Tell whether there are laws for the server's end; plug-ins have none."""
    if controller in CONTROLLERS:
        return server.environment in OBJECTS
    if controller == WAVES and server.coupling == UNKNOWN:
        return is_made(server)
    known = server.coupling in COUPLINGS and server.environment in OBJECTS
    return controller == WAVES and known


def server_params(
    users: Sequence["scenarios.User"],
    *,
    controller: str,
    channel: str,
    server: ServerParams,
    times: ServerTimes,
    axes: int,
) -> ServerStepParams:
    """Return the parameters of the server's step."""
    guests = tuple(
        GuestParams(
            arrivals_params(
                controller,
                channel,
                user.server_impedance,
                timeout_s=times.timeout_s,
                lets_go_s=AVATAR_LETS_GO_S,
                store_j=server.store_j,
            ),
            packing_params(user.contact.deadband),
        )
        for user in users
    )
    strict = is_strict(controller, channel)
    environment = _environment_params(users, controller, server, axes, strict=strict)
    return ServerStepParams(
        guests, environment, server.period_s, times.release_s, times.soft_start_s
    )


def _environment_params(
    users: Sequence["scenarios.User"],
    controller: str,
    server: ServerParams,
    axes: int,
    *,
    strict: bool,
) -> Any:
    if controller in CONTROLLERS:
        made, body = CONTROLLERS[controller], OBJECTS[server.environment](server)
        laws = tuple(made.law(user.baseline, user.master.tick_s) for user in users)
        return AvatarEndParams(laws, body, made.sprung)
    if server.coupling == UNKNOWN:
        return black_box_params(server, _contacts(users, server, axes), axes, brakes=strict)
    coupling = coupling_of(server)
    if isinstance(coupling, Implicit) and _are_coupled(users):
        coupling = ImplicitCoupled(0)
    return EnvironmentParams(coupling, OBJECTS[server.environment](server), strict)


def _contacts(users: Sequence["scenarios.User"], server: ServerParams, axes: int) -> list[Contact]:
    size = server.object_size_m
    return [contact_of(user.contact, side=user.side, size=size, axes=axes) for user in users]


def _are_coupled(users: Sequence["scenarios.User"]) -> bool:
    """Tell whether any impedance of the server couples the axes."""
    return any(isinstance(user.server_impedance, MatrixImpedance) for user in users)


def _impedance(user: "scenarios.User", users: Sequence["scenarios.User"], axes: int) -> Impedance:
    """Return a user's impedance; a matrix where any user's is one."""
    b = user.server_impedance
    if isinstance(b, MatrixImpedance) or not _are_coupled(users):
        return b
    return MatrixImpedance(np.full(axes, float(b)), np.eye(axes))


def resting_server(
    users: Sequence["scenarios.User"],
    p: ServerStepParams,
    *,
    controller: str,
    server: ServerParams,
    axes: int,
) -> Server:
    """Return the server with no user present."""
    rest = (0.0,) * axes
    contacts, ports, guests = _contacts(users, server, axes), [], []
    for user, guest, contact in zip(users, p.guests, contacts, strict=True):
        b = made_impedance(_impedance(user, users, axes))
        avatar = Avatar(False, b, rest, rest, rest, contact, rest)
        kept: Any = AvatarBrake(resting_brake(rest), 0.0)
        if controller in CONTROLLERS:
            kept = CONTROLLERS[controller].at_avatar(user.baseline, axes)
        ports.append(UserPort(avatar, kept, rest, rest, rest, Sums(0.0, 0.0, -1.0), ()))
        rules = guest.arrivals
        arrivals = start_of(rules.plays_on, rules.timeout_s, user.master.frame_s)
        guests.append(Guest(ABSENT, False, arrivals, resting_packing(axes)))
    body: Any = Body(rest, rest)
    if isinstance(p.environment, BlackBoxParams):
        body = resting_box(server, contacts, [user.server_impedance for user in users], axes)
    environment = Environment(tuple(ports), body, 0.0, 0)
    return Server(tuple(guests), environment, float("inf"))
