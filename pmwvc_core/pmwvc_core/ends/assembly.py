# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The assembly of both ends, from parameters or from a scenario.

The live nodes know a part of a scenario each and give their parameters; the simulator gives whole
scenarios. What plug-ins bring of controllers, couplings, compensations and local models is stepped
by the classes that they are written for (:mod:`pmwvc_core.frame`).
"""

from collections.abc import Sequence
from typing import Any

from pmwvc_core.ends.server_end import ServerEnd
from pmwvc_core.ends.user_end import UserEnd
from pmwvc_core.frame.assembly import SERVER_EPOCH, make_force_loop, make_server_step
from pmwvc_core.frame.schedule import AT_ONCE, FrameSchedule
from pmwvc_core.made.server import is_server_made, is_user_made
from pmwvc_core.params import ServerParams, TaskParams
from pmwvc_core.params.user import ServerTimes, server_times
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.server.black_box.containment import Call, directly


def make_user_end(
    user: User,
    *,
    controller: str,
    channel: str,
    dof: int,
    server_period_s: float,
    epoch: int,
    schedule: FrameSchedule,
    workspace_m: float | None = None,
) -> Any:
    """Return a user's force loop, at rest; see :class:`.user_end.UserEnd`."""
    made = UserEnd if is_user_made(controller, user.master) else make_force_loop
    return made(
        user,
        controller=controller,
        channel=channel,
        dof=dof,
        server_period_s=server_period_s,
        epoch=epoch,
        schedule=schedule,
        workspace_m=workspace_m,
    )


def make_server_end(
    users: Sequence[User],
    *,
    controller: str,
    channel: str,
    dof: int,
    server: ServerParams,
    task: TaskParams,
    times: ServerTimes,
    epochs: Sequence[int],
    call: Call = directly,
    idle_until_joined: bool = False,
) -> Any:
    """Return the server's end with no user present; see :class:`.server_end.ServerEnd`. ``call``
    is how a black box from outside is asked.
    """
    common: dict[str, Any] = {
        "controller": controller,
        "channel": channel,
        "dof": dof,
        "server": server,
        "task": task,
        "times": times,
        "epochs": epochs,
        "idle_until_joined": idle_until_joined,
    }
    if is_server_made(controller, server):
        return ServerEnd(users, **common)
    return make_server_step(users, call=call, **common)


def user_end_of(scenario: Scenario, number: int, *, schedule: FrameSchedule = AT_ONCE) -> Any:
    """Return the force loop of user ``number`` (from 0) of a scenario."""
    return make_user_end(
        scenario.users[number],
        controller=scenario.controller,
        channel=scenario.channel,
        dof=scenario.dof,
        server_period_s=scenario.server.period_s,
        epoch=number + 1,
        schedule=schedule,
    )


def server_end_of(scenario: Scenario) -> Any:
    """Return the server's end of a scenario, from the first tick on."""
    return make_server_end(
        scenario.users,
        controller=scenario.controller,
        channel=scenario.channel,
        dof=scenario.dof,
        server=scenario.server,
        task=scenario.task,
        times=server_times(user.safety for user in scenario.users),
        epochs=[SERVER_EPOCH + number for number in range(len(scenario.users))],
    )
