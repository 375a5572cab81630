# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The server node's parameters, and what is made from them.

What holds for all users stands once (``server.contact_stiffness``, ``master.impedance``); with a
user's name in front (``user2.server.contact_stiffness``) it holds for that user.
"""

import dataclasses
from dataclasses import dataclass
from typing import Any

from rclpy.node import Node

from pmwvc_core.controllers import has_waves, make_server
from pmwvc_core.errors import ParameterError
from pmwvc_core.params import (
    BaselineParams,
    ContactParams,
    MasterParams,
    SafetyParams,
    ServerParams,
    TaskParams,
    Validated,
)
from pmwvc_core.params.matrix import matrix_conflicts
from pmwvc_core.plant.task import ShownTarget, Task
from pmwvc_core.runtime.parameters import declare, declare_names, declare_value
from pmwvc_core.scenario.scenario import DEFAULTS, SIDE, TOP
from pmwvc_core.server.service import Service
from pmwvc_core.transport.inboxes import inbox
from pmwvc_core.transport.packet import Packer
from pmwvc_core.wave.impedance import Impedance, server_impedance
from pmwvc_server.asking import caller

LARGEST = 8


def _same_as(owner: type, name: str) -> Any:
    """Declare a field that is the same parameter as one of another dataclass."""
    field = next(field for field in dataclasses.fields(owner) if field.name == name)
    return dataclasses.field(default=field.default, metadata=field.metadata)


@dataclass(frozen=True)
class PortParams(Validated):
    """What the server has to know of a user's master."""

    impedance: float = _same_as(MasterParams, "impedance")
    impedance_matrix: str = _same_as(MasterParams, "impedance_matrix")
    rate_drop: int = _same_as(MasterParams, "rate_drop")
    tick_s: float = _same_as(MasterParams, "tick_s")

    def conflicts(self) -> list[str]:
        """Check that the matrix is one."""
        return matrix_conflicts(self.impedance_matrix)

    @property
    def frame_s(self) -> float:
        """Packet interval of the user [s]."""
        return self.rate_drop * self.tick_s


@dataclass(frozen=True)
class WatchdogParams(Validated):
    """When a user counts as silent, as gone, and begins to act: the times of the masters."""

    timeout_s: float = _same_as(SafetyParams, "timeout_s")
    release_s: float = _same_as(SafetyParams, "release_s")
    soft_start_s: float = _same_as(SafetyParams, "soft_start_s")


@dataclass(frozen=True)
class UserSettings:
    """One user as the server sees it."""

    name: str
    side: int
    port: PortParams
    contact: ContactParams
    baseline: BaselineParams

    @property
    def impedance(self) -> Impedance:
        """Wave impedance of this user's port at the server [N s/m]."""
        return server_impedance(self.contact, self.port)


@dataclass(frozen=True)
class ServerSettings:
    """Everything the node was given."""

    controller: str
    dof: int
    users: tuple[UserSettings, ...]
    server: ServerParams
    watchdog: WatchdogParams
    task: TaskParams

    def make_service(self, epoch: int) -> Service:
        """Return the environment at rest, with nobody there."""
        controller = make_server(
            self.controller,
            self.server,
            [user.contact for user in self.users],
            [user.impedance for user in self.users],
            dof=self.dof,
            sides=[user.side for user in self.users],
            baselines=[user.baseline for user in self.users],
            call=caller(self.server),
        )
        return Service(
            controller,
            inboxes=[
                inbox(
                    self.dof,
                    user.impedance,
                    waves=has_waves(self.controller),
                    period_s=user.port.frame_s,
                    timeout_s=self.watchdog.timeout_s,
                )
                for user in self.users
            ],
            packers=[Packer(epoch, period=self.server.period_s) for _ in self.users],
            release_s=self.watchdog.release_s,
        )

    def make_target(self) -> ShownTarget:
        """Return the target of the task."""
        return ShownTarget(
            Task(self.task),
            period_s=self.server.period_s,
            soft_start_s=self.watchdog.soft_start_s,
            dof=self.dof,
        )


def declare_settings(node: Node) -> ServerSettings:
    """Declare all parameters of the node and return their values.

    Raises
    ------
    ParameterError
        Naming what is wrong.
    """
    names = declare_names(
        node, "users", ["user1", "user2"], f"names (namespaces) of the users, 1 to {LARGEST}"
    )
    if not 1 <= len(names) <= LARGEST:
        raise ParameterError(f"users = {names}: must be 1 to {LARGEST} names")
    port = declare(node, "master", PortParams)
    contact = declare(node, "server", ContactParams)
    baseline = declare(node, "baseline", BaselineParams)
    settings = ServerSettings(
        controller=declare_value(node, "controller", TOP["controller"], "pmwvc"),
        dof=declare_value(node, "dof", TOP["dof"], DEFAULTS["dof"]),
        users=tuple(
            UserSettings(
                name=name,
                side=_side(node, name, -1 if number % 2 == 0 else 1),
                port=declare(node, f"{name}.master", PortParams, defaults=port),
                contact=declare(node, f"{name}.server", ContactParams, defaults=contact),
                baseline=declare(node, f"{name}.baseline", BaselineParams, defaults=baseline),
            )
            for number, name in enumerate(names)
        ),
        server=declare(node, "server", ServerParams),
        watchdog=declare(node, "safety", WatchdogParams),
        task=declare(node, "task", TaskParams),
    )
    for user in settings.users:
        for group, given in (("master", user.port), ("server", user.contact)):
            wrong = matrix_conflicts(given.impedance_matrix, settings.dof)
            if wrong:
                raise ParameterError(f"{user.name}.{group}.{wrong[0]}")
    return settings


def _side(node: Node, name: str, default: int) -> int:
    side: int = declare_value(node, f"{name}.side", SIDE, default)
    if side == 0:
        raise ParameterError(f"{name}.side = 0: must be -1 or 1")
    return side
