# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Both ends of a scenario; live nodes know a part of one each, and make their end themselves."""

from pmwvc_core.ends.server_end import ServerEnd
from pmwvc_core.ends.user_end import UserEnd
from pmwvc_core.frame.schedule import AT_ONCE, FrameSchedule
from pmwvc_core.params.user import server_times
from pmwvc_core.scenario.scenario import Scenario

SERVER_EPOCH = 1000  # of scenarios; random in live sessions, where a process can start again


def user_end_of(scenario: Scenario, number: int, *, schedule: FrameSchedule = AT_ONCE) -> UserEnd:
    """Return the force loop of user ``number`` (from 0) of a scenario."""
    return UserEnd(
        scenario.users[number],
        controller=scenario.controller,
        channel=scenario.channel,
        dof=scenario.dof,
        server_period_s=scenario.server.period_s,
        epoch=number + 1,
        schedule=schedule,
    )


def server_end_of(scenario: Scenario) -> ServerEnd:
    """Return the server's end of a scenario, from the first tick on."""
    return ServerEnd(
        scenario.users,
        controller=scenario.controller,
        channel=scenario.channel,
        dof=scenario.dof,
        server=scenario.server,
        task=scenario.task,
        own=scenario.own,
        times=server_times(user.safety for user in scenario.users),
        epochs=[SERVER_EPOCH + number for number in range(len(scenario.users))],
    )
