# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Sessions in bulk: compiled by Numba, one after the other, each from the laws of its scenario.

Compiled are those of a kind of which there is more to do than compiling takes. Compiled code is
kept on disk, so that later processes only load it. Without Numba every session is interpreted; the
numbers are the same to rounding.
"""

import hashlib
import logging
from collections.abc import Callable, Sequence
from importlib.util import find_spec
from typing import Any, NamedTuple

import numpy as np

from pmwvc_core.controllers.library import LIBRARY, has_waves, record_of
from pmwvc_core.made.server import resting_server, server_params
from pmwvc_core.made.user import made_user
from pmwvc_core.numeric import Array, Integers
from pmwvc_core.plant.device import resting_device, simulated_params
from pmwvc_core.plant.forces import task_of
from pmwvc_core.plant.hands import make_hand
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.server.couplings import COMPENSATIONS, COUPLINGS
from pmwvc_core.server.environments import environment_of
from pmwvc_core.simulation.bulk.loop import OF_PACKET, Book, Clock, EndParams, UserRun, session
from pmwvc_core.simulation.bulk.plan import Network, Plan, network_of, plan_of
from pmwvc_core.simulation.conditions import place_of

SIGNALS = 8  # of a tick
OF_BLOCK = 4 + 21  # cause, interventions, work; energies of a port at most
OF_STEP = 8  # accounts of an environment at most
# Ticks of users that take as long interpreted, on any machine, as it takes to compile a kind of
# session, and to load it.
COMPILING_TICKS, LOADING_TICKS = 400_000, 10_000
LOG = logging.getLogger("pmwvc")


class Run(NamedTuple):
    """What a session left behind, with its plan; ``whole``: all went by that."""

    scenario: Scenario
    plan: Plan
    book: Book
    whole: bool


def can_run(scenario: Scenario) -> bool:
    """Tell whether a session has a plan, and laws for all it consists of."""
    server = scenario.server
    ends = [end for user in scenario.users for end in (user.master, user.contact)]
    return (
        not scenario.changes
        and not any(end.deadband.is_on for end in ends)
        and scenario.controller in LIBRARY
        and (not has_waves(scenario.controller) or server.coupling in COUPLINGS.library)
        and server.compensation in COMPENSATIONS.library
        and environment_of(server.environment).made is not None
    )


def prepared(scenario: Scenario) -> tuple[tuple[Any, ...], Network]:
    """Return what the loop of a session begins with, and the network of its plan."""
    network, users = network_of(scenario), scenario.users
    ends, of_ends = zip(*(made_end(scenario, user) for user in users), strict=True)
    p = server_params(users, scenario, scenario.server)
    server = resting_server(users, scenario, p)
    paces = network.ticks, network.tick_ns, network.period_ticks
    clock = Clock(*paces, tuple(range(len(users))))
    return (ends, server, of_ends, p, clock, task_of(scenario.task, scenario.dof)), network


def run(scenario: Scenario, session: Callable[..., bool] = session) -> Run:
    """Run a session, compiled where the loop given is."""
    begins, network = prepared(scenario)
    plan = plan_of(network)
    book = _book(scenario, network, plan)
    whole = session(*begins, plan.taken_up, plan.taken_down, book)
    return Run(scenario, plan, book, whole)


def made_end(scenario: Scenario, user: User) -> tuple[UserRun, EndParams]:
    """Return the end of a user; ParameterError where it cannot be made."""
    loop, p = made_user(user, scenario)
    at = place_of(user, scenario)
    device = simulated_params(user.device, at.tick_s)
    hand, of_hand = make_hand(user.operator, scenario.task, at)
    start = UserRun(loop, resting_device(at.start, device), hand, False)
    return start, EndParams(p, device, of_hand)


def _book(scenario: Scenario, network: Network, plan: Plan) -> Book:
    users, ticks, axes = len(network.rate_drops), network.ticks, network.dof
    sent = max(len(link.sent) for link in (*plan.up, *plan.down))
    blocks = max(-(-ticks // rate_drop) for rate_drop in network.rate_drops)
    return Book(
        np.zeros((2 * users, sent, 3 * axes + OF_PACKET)),
        np.zeros((users, SIGNALS, ticks, axes)),
        np.zeros((users, blocks, OF_BLOCK)),
        *empty_steps(scenario, -(-ticks // network.period_ticks)),
    )


def empty_steps(scenario: Scenario, steps: int) -> tuple[Array, Array, Integers]:
    """Return the arrays of a :class:`.loop.Book` for so many steps of the server."""
    users, kept = len(scenario.users), len(record_of(scenario.controller).accounts)
    return (
        np.zeros((3 + 5 * users, steps, scenario.dof)),
        np.zeros((steps, 3 + 4 * users + max(kept, OF_STEP))),
        np.zeros((steps, users), dtype=np.int64),
    )


def loops_of(scenarios: Sequence[Scenario]) -> list[Callable[..., bool] | None]:
    """Return the compiled loop for each session that is worth it, in their order; else None."""
    loops: list[Callable[..., bool] | None] = [None] * len(scenarios)
    fit = [i for i, scenario in enumerate(scenarios) if can_run(scenario)]
    if _ticks([scenarios[i] for i in fit]) <= LOADING_TICKS or find_spec("numba") is None:
        return loops
    from pmwvc_core.compiled import compiled, kept_in  # Numba takes its time to load

    try:
        loop, folder = compiled(session, kept=True), kept_in()
    except (OSError, RuntimeError) as error:  # no home, or one that cannot be written
        LOG.warning("sessions are not compiled: %s", error)
        return loops
    kinds: dict[str, list[int]] = {}
    for i in fit:
        kinds.setdefault(_types(prepared(scenarios[i])[0]), []).append(i)
    for kind, members in kinds.items():
        ticks = _ticks([scenarios[i] for i in members])
        mark = folder / hashlib.sha256(kind.encode()).hexdigest()[:16]  # it is kept
        if ticks > COMPILING_TICKS and not mark.exists():
            LOG.warning("compiling the laws of this kind of session, once: half a minute or more")
            run(scenarios[members[0]], loop)
            mark.touch()
        if ticks > LOADING_TICKS and mark.exists():
            for i in members:
                loops[i] = loop
    return loops


def _types(value: Any) -> str:
    """Return the types in nested tuples: sessions with the same share their compiled loop."""
    if isinstance(value, tuple):
        return f"{type(value).__name__}({','.join(map(_types, value))})"
    return type(value).__name__


def _ticks(scenarios: Sequence[Scenario]) -> float:
    """Return how many ticks all users of sessions make."""
    return sum(each.duration_s / each.tick_s * len(each.users) for each in scenarios)
