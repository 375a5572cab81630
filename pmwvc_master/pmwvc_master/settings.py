# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The master node's parameters, and the objects made from them."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from rclpy.node import Node

from pmwvc_core.controllers.library import is_strict
from pmwvc_core.ends.user_end import UserEnd
from pmwvc_core.errors import ParameterError
from pmwvc_core.frame import LIVE
from pmwvc_core.master.safety import check_change
from pmwvc_core.params import MasterParams, SafetyParams, ServerParams, TaskParams, specs
from pmwvc_core.params.ports import port_conflicts
from pmwvc_core.runtime.parameter_values import SHARED_AT_MASTER, USER_AT_MASTER
from pmwvc_core.runtime.parameters import ParameterBinding, declare_top, declare_value
from pmwvc_core.runtime.token_files import TOKEN_FILE, TOKEN_SPEC, token_of_node
from pmwvc_core.scenario.names import NEEDS_STRICT
from pmwvc_core.scenario.scenario import User
from pmwvc_core.transport.packet import Token
from pmwvc_master.devices import DeviceInfo, DeviceSetup, limits_of


@dataclass(frozen=True, kw_only=True)
class MasterSettings(User):
    """Everything the node was given: its user, and what it knows of the session. ``master`` and
    ``safety`` may change while it runs.
    """

    controller: str
    channel: str
    dof: int
    server: ServerParams  # of it what a master needs
    task: TaskParams
    token: Token | None

    @property
    def strict(self) -> bool:
        """Whether the waves run on the strict channel."""
        return is_strict(self.controller, self.channel)

    def check(self, master: MasterParams) -> None:
        """Refuse (ParameterError) a port that axes, channel or receiver cannot do with."""
        waits_s = self.safety.timeout_s
        for wrong in port_conflicts(master, dof=self.dof, strict=self.strict, timeout_s=waits_s):
            raise ParameterError(f"master.{wrong}")

    def make_force_loop(self, epoch: int, info: DeviceInfo) -> UserEnd:
        """Return this user's end of the protocol, for a device that declares this of itself."""
        user = replace(self, given_safety=limits_of(info, self.given_safety, self.server.lever_m))
        return UserEnd(user, self, epoch=epoch, schedule=LIVE)

    def device_setup(self, node: Node) -> DeviceSetup:
        """Return what the device is made for; it starts in front of the user's face."""
        half = self.server.object_size_m / 2
        return DeviceSetup(
            dof=self.dof, tick_s=self.master.tick_s, side=self.side, half_width_m=half,
            start_m=self.side * (half + self.contact.gap_m),
            device=self.given_device, operator=self.operator, task=self.task, node=node,
            lever_m=self.server.lever_m, max_slew_n_s=self.given_safety.max_slew,
        )  # fmt: skip


def declare_settings(
    node: Node,
    on_master: Callable[[MasterParams], None],
    on_safety: Callable[[SafetyParams], None],
) -> MasterSettings:
    """Declare all parameters of the node and return the values; ParameterError if one is wrong."""

    def allowed(old: MasterParams, new: MasterParams) -> None:
        """Refuse a change of the packets that the channel cannot carry."""
        if new.rate_drop != old.rate_drop and not settings.strict:
            raise ParameterError(f"master.rate_drop = {new.rate_drop}: {NEEDS_STRICT}")
        settings.check(new)

    binding = ParameterBinding(node)
    name = node.get_namespace().rpartition("/")[2]
    settings = MasterSettings(
        name=name,
        **declare_top(node),
        side=declare_value(node, "side", specs(User)["side"], -1),
        **binding.declare_shares(SHARED_AT_MASTER),
        **binding.declare_shares(
            USER_AT_MASTER,
            master={"listener": on_master, "check_change": allowed},
            given_safety={"listener": on_safety, "check_change": check_change},
        ),
        token=token_of_node(declare_value(node, TOKEN_FILE, TOKEN_SPEC, ""), user=name),
    )
    settings.check(settings.master)
    return settings
