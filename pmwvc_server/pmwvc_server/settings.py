# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The server node's parameters, and the objects made from them.

What holds for all users at the start stands once (``server.contact_stiffness``,
``master.impedance``), for one with its name in front (``user2.server.contact_stiffness``). Each
user's contact and port, coupling and object may change while the node runs.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from rclpy.node import Node

from pmwvc_core.controllers.library import is_strict
from pmwvc_core.ends.server_end import ServerEnd
from pmwvc_core.errors import ParameterError
from pmwvc_core.made.server import coupling_of
from pmwvc_core.params import (
    ContactParams,
    MasterParams,
    SafetyParams,
    ServerParams,
    TaskParams,
    specs,
)
from pmwvc_core.params.ports import port_conflicts
from pmwvc_core.params.user import ServerTimes, server_times
from pmwvc_core.runtime.parameter_values import SHARED_AT_SERVER, USER_AT_SERVER
from pmwvc_core.runtime.parameters import (
    ParameterBinding,
    declare,
    declare_names,
    declare_top,
    declare_value,
)
from pmwvc_core.runtime.token_files import TOKEN_FILE, TOKEN_SPEC, token_of_node
from pmwvc_core.scenario.names import FIXED, PERIOD, why_fixed
from pmwvc_core.scenario.scenario import User
from pmwvc_core.server.couplings import COUPLINGS
from pmwvc_core.transport.packet import Token
from pmwvc_server.asking import caller

LARGEST = 8


@dataclass(frozen=True)
class ServerSettings:
    """Everything the node was given."""

    controller: str
    channel: str
    dof: int
    users: tuple[User, ...]  # of their masters what the server needs
    server: ServerParams
    times: ServerTimes
    task: TaskParams
    own: Any  # of environments from other packages, by their names
    token: Token | None

    def make_step(self, epoch: int) -> ServerEnd:
        """Return the server's end of the protocol at rest, with no user present."""
        return ServerEnd(self, epoch=epoch, call=caller(self.server), idle_until_joined=True)

    def check(self, name: str, port: MasterParams | ContactParams) -> None:
        """Refuse (ParameterError) a port that axes, channel or receiver cannot do with."""
        has: dict[str, Any] = {"dof": self.dof, "timeout_s": self.times.timeout_s}
        for wrong in port_conflicts(port, strict=is_strict(self.controller, self.channel), **has):
            raise ParameterError(f"{name}.{wrong}")

    def check_contact(self, old: ContactParams, new: ContactParams) -> None:
        """Refuse what a black box would not notice."""
        if COUPLINGS.of(self.server.coupling).black_box and new != old:
            raise ParameterError(f"server: {FIXED}")
        self.check("server", new)

    def check_server(self, old: ServerParams, new: ServerParams) -> None:
        """Refuse changes around a black box, of a fixed period, or to an impossible coupling."""
        couplings = [COUPLINGS.of(params.coupling) for params in (old, new)]
        if new != old and any(coupling.black_box for coupling in couplings):
            raise ParameterError(f"server.coupling = {new.coupling!r}: {FIXED}")
        if (new.coupling, new.integrator) != (old.coupling, old.integrator):
            coupling_of(new)
        strict = is_strict(self.controller, self.channel)
        fixed = why_fixed(PERIOD, strict=strict, server=new, coupling=couplings[1])
        if fixed and new.period_s != old.period_s:
            raise ParameterError(f"{PERIOD} = {new.period_s:g}: {fixed}")


def declare_settings(
    node: Node,
    on_server: Callable[[ServerParams], None],
    on_contact: Callable[[int, ContactParams], None],
    settled: Callable[[], None],
) -> ServerSettings:
    """Declare all parameters of the node and return the values; ParameterError if one is wrong.

    After each accepted change ``on_server`` or ``on_contact`` (with the number of the user, from
    0) gets complete new parameters, then ``settled`` is called once for all, in the thread that
    serves parameters.
    """
    binding = ParameterBinding(node, settled=settled)
    what = f"names (namespaces) of the users, 1 to {LARGEST}"
    names = declare_names(node, "users", ["user1", "user2"], what)
    if not 1 <= len(names) <= LARGEST:
        raise ParameterError(f"users = {names}: must be 1 to {LARGEST} names")
    common, side = binding.declare_shares(USER_AT_SERVER), specs(User)["side"]

    def contact(number: int) -> dict[str, Any]:
        return {
            "listener": partial(on_contact, number),
            "check_change": lambda old, new: settings.check_contact(old, new),
        }

    settings: ServerSettings = ServerSettings(
        **declare_top(node),
        users=tuple(
            User(
                name=name,
                side=declare_value(node, f"{name}.side", side, -1 if number % 2 == 0 else 1),
                **binding.declare_shares(
                    USER_AT_SERVER, name, defaults=common, contact=contact(number)
                ),
            )
            for number, name in enumerate(names)
        ),
        times=server_times([declare(node, "safety", SafetyParams, only=ServerTimes._fields)]),
        **binding.declare_shares(
            SHARED_AT_SERVER,
            server={
                "listener": on_server,
                "check_change": lambda old, new: settings.check_server(old, new),
            },
        ),
        token=token_of_node(declare_value(node, TOKEN_FILE, TOKEN_SPEC, ""), user=""),
    )
    for user in settings.users:
        settings.check(f"{user.name}.master", user.master)
        settings.check(f"{user.name}.server", user.contact)
    return settings
