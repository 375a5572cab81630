# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The assembly of both ends of the frame protocol, from parameters or from a scenario.

The live nodes know a part of a scenario each and give their parameters; the simulator gives whole
scenarios. Receivers get the same rules either way (:mod:`.receivers`): a wave longer than any that
a port of this impedance can emit is refused, and the server is silent to all users after the
longest of their timeouts. On the strict channel the master's end also keeps the account of its
node.
"""

from collections.abc import Sequence

from pmwvc_core.controllers.ends import make_master, make_server
from pmwvc_core.controllers.library import PLAIN, is_strict
from pmwvc_core.frame.force_loop import ForceLoop
from pmwvc_core.frame.receivers import make_receiver
from pmwvc_core.frame.schedule import AT_ONCE, Frames, FrameSchedule
from pmwvc_core.frame.server_step import ServerStep
from pmwvc_core.master.brake import RETURN_S as DEVICE_LETS_GO_S
from pmwvc_core.master.brake import brake_of
from pmwvc_core.master.safety.limiter import SafetyLimiter
from pmwvc_core.params import ServerParams, TaskParams
from pmwvc_core.params.user import ServerTimes, server_times
from pmwvc_core.plant.task import ShownTarget, Task
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.server.avatar_brake import RETURN_S as AVATAR_LETS_GO_S
from pmwvc_core.server.black_box.containment import Call, directly
from pmwvc_core.transport.deadband import Deadband
from pmwvc_core.transport.packet import Packer
from pmwvc_core.transport.strict_receiver import StrictReceiver

SERVER_EPOCH = 1000  # of scenarios; random in live sessions, where a process can start again


def make_force_loop(
    user: User,
    *,
    controller: str,
    channel: str = PLAIN,
    dof: int,
    server_period_s: float,
    epoch: int,
    schedule: FrameSchedule,
    workspace_m: float | None = None,
) -> ForceLoop:
    """Return a user's force loop, at rest.

    Parameters
    ----------
    user
        Of it master, baseline and safety.
    controller, channel, dof, server_period_s
        Of the session: controller and channel by name, axes, time step of the server [s].
    schedule
        Phases of a frame.
    workspace_m
        Half extent that the device declares [m].
    """
    inbox = make_receiver(
        controller,
        channel,
        dof,
        user.impedance,
        period_s=server_period_s,
        timeout_s=user.safety.timeout_s,
        lets_go_s=DEVICE_LETS_GO_S,
        store_j=user.master.store_j,
    )
    packer = Packer(epoch, period=user.master.frame_s, deadband=Deadband(user.master.deadband))
    brake = ends = None
    if isinstance(inbox, StrictReceiver):
        brake = brake_of(user.master)
        ends = (inbox.playout, packer, brake)
    return ForceLoop(
        make_master(controller, user.master, user.baseline, strict=ends),
        SafetyLimiter(
            user.safety,
            tick_s=user.master.tick_s,
            packet_s=server_period_s,
            workspace_m=workspace_m,
            brake=brake,
        ),
        inbox=inbox,
        packer=packer,
        frames=Frames(schedule, rate_drop=user.master.rate_drop, tick_s=user.master.tick_s),
        tick_s=user.master.tick_s,
    )


def make_server_step(
    users: Sequence[User],
    *,
    controller: str,
    channel: str = PLAIN,
    dof: int,
    server: ServerParams,
    task: TaskParams,
    times: ServerTimes,
    epochs: Sequence[int],
    call: Call = directly,
    idle_until_joined: bool = False,
) -> ServerStep:
    """Return the server's step with no user present.

    Parameters
    ----------
    users
        Of each the side, contact, baseline, and the impedance and frame of the master.
    controller, channel, dof, server, task
        Of the session.
    times
        Silence, release and start.
    epochs
        Of the packets to each user.
    idle_until_joined
        Whether steps begin with the first user.
    """
    end = make_server(
        controller,
        server,
        [user.contact for user in users],
        [user.server_impedance for user in users],
        dof=dof,
        sides=[user.side for user in users],
        baselines=[user.baseline for user in users],
        call=call,
    )
    if is_strict(controller, channel):
        end.fit_brakes(server.period_s)
    return ServerStep(
        end,
        ShownTarget(
            Task(task), period_s=server.period_s, soft_start_s=times.soft_start_s, dof=dof
        ),
        inboxes=[
            make_receiver(
                controller,
                channel,
                dof,
                user.server_impedance,
                period_s=user.master.frame_s,
                timeout_s=times.timeout_s,
                lets_go_s=AVATAR_LETS_GO_S,
                store_j=server.store_j,
            )
            for user in users
        ],
        packers=[
            Packer(epoch, period=server.period_s, deadband=Deadband(user.contact.deadband))
            for epoch, user in zip(epochs, users, strict=True)
        ],
        params=server,
        release_s=times.release_s,
        idle_until_joined=idle_until_joined,
    )


def force_loop_of(
    scenario: Scenario,
    number: int,
    *,
    schedule: FrameSchedule = AT_ONCE,
    dof: int | None = None,
) -> ForceLoop:
    """Return the force loop of user ``number`` (from 0) of a scenario, or of some of its axes."""
    return make_force_loop(
        scenario.users[number],
        controller=scenario.controller,
        channel=scenario.channel,
        dof=dof or scenario.dof,
        server_period_s=scenario.server.period_s,
        epoch=number + 1,
        schedule=schedule,
    )


def server_step_of(scenario: Scenario, *, dof: int | None = None) -> ServerStep:
    """Return the server's step of a scenario, or of some of its axes, from the first tick on."""
    return make_server_step(
        scenario.users,
        controller=scenario.controller,
        channel=scenario.channel,
        dof=dof or scenario.dof,
        server=scenario.server,
        task=scenario.task,
        times=server_times(user.safety for user in scenario.users),
        epochs=[SERVER_EPOCH + number for number in range(len(scenario.users))],
    )
