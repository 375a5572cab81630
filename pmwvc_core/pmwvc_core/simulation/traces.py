# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The traces of a session in virtual time: of rows noted while it was stepped, or of the arrays of
one that ran in bulk (:mod:`.bulk.loop`).
"""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from pmwvc_core import traces as of
from pmwvc_core.controllers.library import accounts_of_server, accounts_of_user
from pmwvc_core.frame import SIGNALS, ServerRow
from pmwvc_core.master.safety import state_of, text_of
from pmwvc_core.numeric import Array, Integers
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.bulk.loop import OF_PACKET
from pmwvc_core.simulation.bulk.plan import Plan
from pmwvc_core.simulation.bulk.run import Run, empty_steps
from pmwvc_core.simulation.conditions import add_link
from pmwvc_core.traces import ENERGIES, ServerTraces, SessionTraces, UserTraces, contact_rows


class Step(NamedTuple):
    """A step of the server: tick, when it ran [ns], length [s], how many steps have taken changes
    over, and the server after it, as :func:`.bulk.run.empty_steps` and as its end tells it.
    """

    tick: int
    ran_ns: int
    period_s: float
    changes: int
    arrays: tuple[Array, Array, Integers]
    row: ServerRow


def stepped_server(scenario: Scenario, steps: Sequence[Step], time_s: Array) -> ServerTraces:
    """Return the traces of the server's steps, given when they began [s]."""
    rows = zip(empty_steps(scenario, 0), *(step.arrays for step in steps), strict=True)
    arrays = (np.concatenate(each, axis) for each, axis in zip(rows, (1, 0, 0), strict=True))
    tick_ns, bodies = round(scenario.tick_s * 1e9), steps[0].row.poses if steps else ()
    late_ns = [step.ran_ns - step.tick * tick_ns for step in steps]
    return server_traces(
        scenario, *arrays, time_s=time_s, looked_ns=np.array(late_ns, dtype=np.int64),
        periods_s=np.array([step.period_s for step in steps], dtype=float),
        changes=np.array([step.changes for step in steps], dtype=np.int64),
        poses={name: np.array([step.row.poses[name] for step in steps]) for name in bodies},
        contacts=contact_rows([step.row.contacts for step in steps]),
        contained=np.array([step.row.contained for step in steps], dtype=np.int64),
    )  # fmt: skip


def server_traces(
    scenario: Scenario, steps: Array, energies: Array, presence: Integers, **rest: Any
) -> ServerTraces:
    """Return the traces of the server from the arrays that a :class:`.bulk.loop.Book` has."""
    users = len(scenario.users)
    first, of_each = [2 + len(of.OF_AVATARS) * i for i in range(users)], enumerate(of.OF_AVATARS)
    avatars: dict[str, Any] = {name: [steps[at + k] for at in first] for k, name in of_each}
    u_j, v_j, touches, _ = energies[:, 3 : 3 + 4 * users].T.reshape(users, 4, -1).swapaxes(0, 1)
    kinetic, potential, dissipated = energies[:, :3].T.copy()
    own = accounts_of_server(scenario.controller, scenario.channel, scenario.server)
    accounts = {each.name: energies[:, k].copy() for k, each in enumerate(own, 3 + 4 * users)}
    return ServerTraces(
        users=[user.name for user in scenario.users], x_o=steps[0], xd_o=steps[1],
        step=np.arange(1, len(energies) + 1, dtype=np.int64), target=steps[-1],
        contact=list(touches != 0.0), state=list(presence.T.copy()),
        energy_u_s=list(u_j.copy()), energy_v_s=list(v_j.copy()), kinetic=kinetic,
        potential=potential, dissipated=dissipated, accounts=accounts, **avatars, **rest,
    )  # fmt: skip


def learned_events(scenario: Scenario, energies: Array) -> Iterator[dict[str, Any]]:
    """Return what servers' ports learned of their contacts, (K T + 2B)/b, where it is above 1."""
    for k, user in enumerate(scenario.users):
        if (ratio := energies[-1, 6 + 4 * k]) > 1.0:
            what = f"its server port learned K T + 2B = {ratio:.3g} b"
            yield {"time_s": None, "kind": "environment", "who": user.name, "what": what}


def traces_of(run: Run) -> SessionTraces:
    """Return the traces of a session in bulk."""
    scenario, book = run.scenario, run.book
    names, count = [user.name for user in scenario.users], len(book.energies)
    period_s, none = scenario.server.period_s, np.zeros((3, count), dtype=np.int64)
    server = server_traces(
        scenario, book.steps, book.energies, book.presence, periods_s=np.full(count, period_s),
        time_s=scenario.tick_s * (scenario.period_ticks * np.arange(count, dtype=np.float64)),
        changes=none[0], looked_ns=none[1], contained=none[2],
    )  # fmt: skip
    users, duration_s = range(len(names)), book.signals.shape[2] * scenario.tick_s
    traces = SessionTraces("simulated", duration_s, [_user(run, each) for each in users], server)
    ways = itertools.product(names, ("up", "down"))
    for (name, way), link, rows in zip(ways, _links(run.plan), book.packets, strict=True):
        fates, reception, taken, planned = link
        packets = [_packets(seen, rows) for seen in planned]
        add_link(traces, name, way, fates, reception, taken, packets)
    traces.events += learned_events(scenario, book.energies)
    return traces


def _user(run: Run, number: int) -> UserTraces:
    user, tick_s = run.scenario.users[number], run.scenario.tick_s
    signals, blocks = run.book.signals[number], run.book.blocks[number]
    ticks = signals.shape[1]
    every = np.arange(ticks, dtype=np.int64)
    ends = np.append(np.arange(user.master.rate_drop, ticks, user.master.rate_drop), ticks)
    blocks = blocks[: len(ends)]
    causes, which = np.unique(blocks[:, 0].astype(np.int64), return_inverse=True)
    texts = [str(text_of(cause, user.given_safety)) for cause in causes.tolist()]
    own = accounts_of_user(run.scenario.controller, run.scenario.channel, user.master)
    return UserTraces(
        name=user.name, tick_s=tick_s, time_s=every.astype(np.float64) * tick_s, tick=every,
        lateness_s=np.zeros(ticks), compute_s=np.zeros(ticks), block_time_s=ends * tick_s,
        state=np.array([state_of(cause) for cause in causes.tolist()], dtype=np.int64)[which],
        reason=[texts[i] for i in which.tolist()],
        energy=dict(zip(ENERGIES, blocks[:, [4, 5, 6, 7, 2, 3]].T.copy(), strict=True)),
        accounts={each.name: blocks[:, 8 + k].copy() for k, each in enumerate(own)},
        changes=np.zeros(len(ends), dtype=np.int64), looked_ns=np.zeros(ticks, dtype=np.int64),
        safety_events=int(blocks[-1, 1]), orientation=np.zeros((len(ends), 0)),
        **dict(zip(SIGNALS, signals, strict=True)),
    )  # fmt: skip


@lru_cache(maxsize=8)
def _links(plan: Plan) -> list[Any]:
    """Return what a plan says of the links, up and down of each user; arrays are shared."""
    both = zip(plan.up, plan.down, strict=True)
    return [link.traces(plan.looks_ns[way]) for pair in both for way, link in enumerate(pair)]


def _packets(planned: of.PacketTraces, rows: Array) -> of.PacketTraces:
    """Return packets of a plan with what a session put into them."""
    found, dof = rows[planned.seq - 1], (rows.shape[1] - OF_PACKET) // 3
    return replace(
        planned, sent_ns=found[:, 3 * dof + 2].astype(np.int64),
        period_s=found[:, 3 * dof + 1].copy(), wave=found[:, :dof].copy(),
        integral=found[:, dof : 2 * dof].copy(), energy=found[:, 3 * dof].copy(),
        position=found[:, 2 * dof : 3 * dof].copy(),
    )  # fmt: skip
