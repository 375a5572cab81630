# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Sessions in bulk: compiled by Numba, one after the other, each from the laws of its scenario."""

from typing import Any, NamedTuple

import numpy as np

from pmwvc_core.compiled import compiled
from pmwvc_core.frame.made import resting_server, resting_user, server_params, user_params
from pmwvc_core.law.device import resting_device, simulated_params
from pmwvc_core.law.user_tick import UserParams
from pmwvc_core.numeric import Array
from pmwvc_core.params.user import server_times
from pmwvc_core.plant.hands import Place, make_hand
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.bulk_loop import Clock, End, EndParams, Line, Steps, Wire, session
from pmwvc_core.simulation.plan import Plan, Planned, network_of, plan_of

SIGNALS, ENERGIES = 8, 4  # of a tick; beside its energies of a block


class Run(NamedTuple):
    """What a session left behind, with its plan; ``whole``: all went by that."""

    scenario: Scenario
    plan: Plan
    lines: tuple[Line, ...]
    steps: Steps
    whole: bool


def run(scenario: Scenario) -> Run:
    """Run a session."""
    plan = plan_of(network_of(scenario))
    ends, params, lines = [], [], []
    for i, user in enumerate(scenario.users):
        p = user_params(
            user,
            controller=scenario.controller,
            channel=scenario.channel,
            packet_s=scenario.server.period_s,
            answer_tick=0,
        )
        end, of_end = _end(scenario, i, p)
        ends.append(end)
        params.append(of_end)
        blocks = -(-network_of(scenario).ticks // user.master.rate_drop)
        lines.append(
            Line(
                _wire(plan.taken_up[i], len(plan.up[i].sent), scenario.dof, _longest(scenario, i)),
                _wire(
                    plan.taken_down[i], len(plan.down[i].sent), scenario.dof, p.arrivals.longest
                ),
                np.zeros((SIGNALS, network_of(scenario).ticks, scenario.dof)),
                np.zeros((blocks, ENERGIES + 9)),
            )
        )
    times = server_times(user.safety for user in scenario.users)
    p = server_params(
        scenario.users,
        controller=scenario.controller,
        channel=scenario.channel,
        server=scenario.server,
        times=times,
    )
    server = resting_server(scenario.users, p, scenario.server, scenario.dof)
    ticks, users = network_of(scenario).ticks, len(scenario.users)
    count = -(-ticks // scenario.period_ticks)
    steps = Steps(
        np.zeros((2 + 5 * users, count, scenario.dof)),
        np.zeros((count, 4 + 4 * users)),
        np.zeros((count, users), dtype=np.int64),
    )
    clock = Clock(
        ticks, round(scenario.tick_s * 1e9), scenario.period_ticks, tuple(range(scenario.dof))
    )
    whole = compiled(session)(tuple(ends), server, tuple(lines), steps, tuple(params), p, clock)
    return Run(scenario, plan, tuple(lines), steps, bool(whole))


def _longest(scenario: Scenario, user: int) -> float:
    times = server_times(each.safety for each in scenario.users)
    p = server_params(
        scenario.users,
        controller=scenario.controller,
        channel=scenario.channel,
        server=scenario.server,
        times=times,
    )
    return p.guests[user].arrivals.longest


def _end(scenario: Scenario, number: int, p: UserParams) -> tuple[End, EndParams]:
    user, axes, tick_s = scenario.users[number], scenario.dof, scenario.tick_s
    half = scenario.server.object_size_m / 2
    at = Place(user.side, half, user.side * (half + user.contact.gap_m), tick_s, axes)
    device = simulated_params(user.device, tick_s)
    hand, of_hand = make_hand(user.operator, scenario.task, at)
    loop = resting_user(user, p, axes, scenario.server.period_s)
    start = End(loop, resting_device(at.start, device), hand, False, 0, 0, 0)
    return start, EndParams(p, device, of_hand)


def _wire(planned: Planned, packets: int, axes: int, longest: float) -> Wire:
    values: Array = np.zeros((packets, 3 * axes + 3))
    return Wire(values, np.zeros((packets, 3), dtype=np.int64), *planned, longest)
