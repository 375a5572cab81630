# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Sessions in bulk: compiled by Numba, one after the other, each from the laws of its scenario."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from pmwvc_core.made.server import of_library, resting_server, server_params
from pmwvc_core.made.user import resting_user, user_params
from pmwvc_core.params.user import server_times
from pmwvc_core.plant.device import resting_device, simulated_params
from pmwvc_core.plant.hands import make_hand
from pmwvc_core.plant.task import Task, task_of
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.bulk.book import OF_PACKET, Book
from pmwvc_core.simulation.bulk.loop import Clock, End, EndParams, session
from pmwvc_core.simulation.bulk.plan import Network, Plan, is_planned, network_of, plan_of
from pmwvc_core.simulation.conditions import place_of

SIGNALS = 8  # of a tick
OF_BLOCK = 4 + 21  # cause, interventions, work; energies of a port at most
OF_STEP = 8  # accounts of an environment at most


class Run(NamedTuple):
    """What a session left behind, with its plan; ``whole``: all went by that."""

    scenario: Scenario
    plan: Plan
    book: Book
    whole: bool


def can_run(scenario: Scenario) -> bool:
    """Tell whether a session has a plan, and laws for all it consists of."""
    return is_planned(scenario) and of_library(scenario)


class Prepared(NamedTuple):
    """What the loop of a session is called with."""

    ends: tuple[End, ...]
    server: Any
    users: tuple[EndParams, ...]
    p: Any
    clock: Clock
    task: Task
    network: Network


def prepared(scenario: Scenario) -> Prepared:
    """Return what the loop of a session begins with."""
    network = network_of(scenario)
    made = [_end(scenario, number) for number in range(len(scenario.users))]
    of: dict[str, Any] = {"controller": scenario.controller, "server": scenario.server}
    of["axes"], times = scenario.dof, server_times(user.safety for user in scenario.users)
    p = server_params(scenario.users, channel=scenario.channel, times=times, **of)
    server = resting_server(scenario.users, p, **of)
    ends, users = tuple(end for end, _ in made), tuple(params for _, params in made)
    paces = network.ticks, network.tick_ns, network.period_ticks
    clock = Clock(*paces, tuple(range(len(users))), tuple(range(scenario.dof)))
    task = task_of(scenario.task, scenario.dof)
    return Prepared(ends, server, users, p, clock, task, network)


def run(scenario: Scenario, session: Callable[..., bool] = session) -> Run:
    """Run a session, compiled where the loop given is."""
    *begins, network = prepared(scenario)
    plan = plan_of(network)
    book = _book(network, plan)
    return Run(scenario, plan, book, session(*begins, book))


def _end(scenario: Scenario, number: int) -> tuple[End, EndParams]:
    user, axes = scenario.users[number], scenario.dof
    of: dict[str, Any] = {"controller": scenario.controller, "packet_s": scenario.server.period_s}
    p = user_params(user, channel=scenario.channel, answer_tick=0, **of)
    at = place_of(user, scenario)
    device = simulated_params(user.device, at.tick_s)
    hand, of_hand = make_hand(user.operator, scenario.task, at)
    loop = resting_user(user, p, axes=axes, **of)
    start = End(loop, resting_device(at.start, device), hand, False, 0, 0, 0)
    return start, EndParams(p, device, of_hand)


def _book(network: Network, plan: Plan) -> Book:
    users, ticks, axes = len(network.rate_drops), network.ticks, network.dof
    sent = max(len(link.sent) for link in (*plan.up, *plan.down))
    blocks = max(-(-ticks // rate_drop) for rate_drop in network.rate_drops)
    steps = -(-ticks // network.period_ticks)
    return Book(
        plan.taken_up,
        plan.taken_down,
        np.zeros((2 * users, sent, 3 * axes + OF_PACKET)),
        np.zeros((users, SIGNALS, ticks, axes)),
        np.zeros((users, blocks, OF_BLOCK)),
        np.zeros((3 + 5 * users, steps, axes)),
        np.zeros((steps, 3 + 4 * users + OF_STEP)),
        np.zeros((steps, users), dtype=np.int64),
    )
