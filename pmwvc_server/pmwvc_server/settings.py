# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The server node's parameters, and the objects made from them.

What holds for all users stands once (``server.contact_stiffness``, ``master.impedance``); with a
user's name in front (``user2.server.contact_stiffness``) it holds for that user. Contact, port,
coupling and object may change while the node runs; the last word counts, and a change for all
users goes to each of them.
"""

from collections.abc import Callable, Mapping
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
    SafetyParams,
    ServerParams,
    TaskParams,
    Validated,
    specs,
)
from pmwvc_core.params.fields import parameter
from pmwvc_core.params.ports import port_conflicts
from pmwvc_core.params.user import ServerTimes, server_times
from pmwvc_core.runtime.parameter_values import SHARED_AT_SERVER, USER_AT_SERVER
from pmwvc_core.runtime.parameters import (
    ParameterBinding,
    declare,
    declare_names,
    declare_top,
    declare_value,
    pass_on,
)
from pmwvc_core.runtime.token_files import TOKEN_FILE, TOKEN_SPEC, token_of_node
from pmwvc_core.scenario.names import FIXED, PERIOD, why_fixed
from pmwvc_core.scenario.scenario import User
from pmwvc_core.server.couplings import COUPLINGS
from pmwvc_core.transport.packet import Token
from pmwvc_server.asking import caller


@dataclass(frozen=True)
class PauseParams(Validated):
    """A parameter of the node alone, which no scenario has."""

    paused: bool = parameter(
        False, "-", "the object stands still, users are taken out and join anew afterwards"
    )


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


def declare_settings(
    node: Node, on_server: Callable[[ServerParams], None], on_contact: Callable[[int,
    ContactParams], None], on_pause: Callable[[PauseParams], None], settled: Callable[[], None],
) -> ServerSettings:  # fmt: skip
    """Declare all parameters of the node and return the values; ParameterError if one is wrong.

    After each accepted change ``on_server``, ``on_contact`` (with the number of the user, from 0)
    and ``on_pause`` get complete new parameters, then ``settled`` is called once for all, in the
    thread that serves parameters.
    """
    binding = ParameterBinding(node, settled=settled)
    binding.declare("", PauseParams, on_pause)
    what = f"names (namespaces) of the users, 1 to {LARGEST}"
    names = declare_names(node, "users", ["user1", "user2"], what)
    if not 1 <= len(names) <= LARGEST:
        raise ParameterError(f"users = {names}: must be 1 to {LARGEST} names")
    for_all = _ForAll(node, names)
    common = binding.declare_shares(USER_AT_SERVER, contact={"listener": for_all.pass_on})
    for_all.contact = common["contact"]
    change, side = for_all.check_change, specs(User)["side"]
    settings = ServerSettings(
        **declare_top(node),
        users=tuple(
            User(
                name=name,
                side=declare_value(node, f"{name}.side", side, -1 if number % 2 == 0 else 1),
                **binding.declare_shares(
                    USER_AT_SERVER,
                    name,
                    defaults=common,
                    contact={"listener": partial(on_contact, number), "check_change": change},
                ),
            )
            for number, name in enumerate(names)
        ),
        times=server_times([declare(node, "safety", SafetyParams, only=ServerTimes._fields)]),
        **binding.declare_shares(
            SHARED_AT_SERVER, server={"listener": on_server, "check_change": for_all.check}
        ),
        token=token_of_node(declare_value(node, TOKEN_FILE, TOKEN_SPEC, ""), user=""),
    )
    for_all.black_box = COUPLINGS.of(settings.server.coupling).black_box
    for_all.strict = is_strict(settings.controller, settings.channel)
    timeout_s = settings.times.timeout_s
    for_all.receiver = {"dof": settings.dof, "strict": for_all.strict, "timeout_s": timeout_s}
    for user in settings.users:
        if user.side == 0:
            raise ParameterError(f"{user.name}.side = 0: must be -1 or 1")
        for group, given in (("master", user.master), ("server", user.contact)):
            for wrong in port_conflicts(given, **for_all.receiver):
                raise ParameterError(f"{user.name}.{group}.{wrong}")
    return settings


class _ForAll:
    """The contact for all users, and what may change of any contact."""

    contact = ContactParams()
    black_box = strict = False
    receiver: Mapping[str, Any] = {"dof": None, "strict": False, "timeout_s": 0.0}

    def __init__(self, node: Node, users: list[str]) -> None:
        self._node, self._users = node, users

    def pass_on(self, new: ContactParams) -> None:
        """Hand what changed for all users to each of them."""
        old, self.contact = self.contact, new
        pass_on(self._node, self._users, "server", old, new)

    def check_change(self, old: ContactParams, new: ContactParams) -> None:
        """Refuse what a black box would not notice."""
        if self.black_box and new != old:
            raise ParameterError(f"server: {FIXED}")
        for wrong in port_conflicts(new, **self.receiver):
            raise ParameterError(f"server.{wrong}")

    def check(self, old: ServerParams, new: ServerParams) -> None:
        """Refuse changes around a black box, of a fixed period, or to an impossible coupling."""
        couplings = [COUPLINGS.of(params.coupling) for params in (old, new)]
        if new != old and any(coupling.black_box for coupling in couplings):
            raise ParameterError(f"server.coupling = {new.coupling!r}: {FIXED}")
        if (new.coupling, new.integrator) != (old.coupling, old.integrator):
            coupling_of(new, ())
        fixed = why_fixed(PERIOD, strict=self.strict, server=new, coupling=couplings[1])
        if fixed and new.period_s != old.period_s:
            raise ParameterError(f"{PERIOD} = {new.period_s:g}: {fixed}")
