# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The traces of a session that ran in bulk."""

import itertools
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from pmwvc_core.controllers.library import accounts_of_server, accounts_of_user
from pmwvc_core.frame.rows import SIGNALS
from pmwvc_core.master.safety import state_of, text_of
from pmwvc_core.numeric import Array
from pmwvc_core.simulation.bulk.book import OF_PACKET
from pmwvc_core.simulation.bulk.plan import Plan
from pmwvc_core.simulation.bulk.run import Run
from pmwvc_core.simulation.links import add_link
from pmwvc_core.simulation.notes import server_traces
from pmwvc_core.traces import ENERGIES, PacketTraces, ServerTraces, SessionTraces, UserTraces


def traces_of(run: Run) -> SessionTraces:
    """Return the traces of a session."""
    scenario, book = run.scenario, run.book
    names = [user.name for user in scenario.users]
    traces = SessionTraces(
        source="simulated",
        duration_s=book.signals.shape[2] * scenario.tick_s,
        users=[_user(run, user) for user in range(len(names))],
        server=_server(run, names),
    )
    ways = itertools.product(names, ("up", "down"))
    for (name, way), link, rows in zip(ways, _links(run.plan), book.packets, strict=True):
        fates, reception, taken, planned = link
        packets = [_packets(seen, rows) for seen in planned]
        add_link(traces, name, way, fates, reception, taken, packets)
    learned = book.energies[-1, 6 : 6 + 4 * len(names) : 4].tolist()
    traces.events += learned_events(names, learned)
    return traces


def learned_events(users: Sequence[str], ratios: Sequence[float]) -> list[dict[str, Any]]:
    """Return what servers' ports learned of their contacts, (K T + 2B)/b, where it is above 1."""
    of = {"time_s": None, "kind": "environment"}
    text = "its server port learned K T + 2B = {:.3g} b"
    pairs = zip(users, ratios, strict=True)
    return [{**of, "who": user, "what": text.format(k)} for user, k in pairs if k > 1.0]


def _user(run: Run, number: int) -> UserTraces:
    user, tick_s = run.scenario.users[number], run.scenario.tick_s
    signals, blocks = run.book.signals[number], run.book.blocks[number]
    ticks = signals.shape[1]
    every = np.arange(ticks, dtype=np.int64)
    ends = np.append(np.arange(user.master.rate_drop, ticks, user.master.rate_drop), ticks)
    blocks = blocks[: len(ends)]
    causes, which = np.unique(blocks[:, 0].astype(np.int64), return_inverse=True)
    texts = [str(text_of(cause, user.safety)) for cause in causes.tolist()]
    own = accounts_of_user(run.scenario.controller, run.scenario.channel, user.master)
    return UserTraces(
        name=user.name,
        tick_s=tick_s,
        time_s=every.astype(np.float64) * tick_s,
        tick=every,
        lateness_s=np.zeros(ticks),
        compute_s=np.zeros(ticks),
        block_time_s=ends * tick_s,
        state=np.array([state_of(cause) for cause in causes.tolist()], dtype=np.int64)[which],
        reason=[texts[i] for i in which.tolist()],
        energy=dict(zip(ENERGIES, blocks[:, [4, 5, 6, 7, 2, 3]].T.copy(), strict=True)),
        accounts={each.name: blocks[:, 8 + k].copy() for k, each in enumerate(own)},
        changes=np.zeros(len(ends), dtype=np.int64),
        looked_ns=np.zeros(ticks, dtype=np.int64),
        safety_events=int(blocks[-1, 1]),
        **dict(zip(SIGNALS, signals, strict=True)),
    )


def _server(run: Run, users: list[str]) -> ServerTraces:
    scenario, energies = run.scenario, run.book.energies
    steps, period_s, first = len(energies), scenario.server.period_s, 3 + 4 * len(users)
    own = accounts_of_server(scenario.controller, scenario.channel, scenario.server)
    return server_traces(
        users,
        time_s=np.arange(steps, dtype=np.float64) * period_s,
        periods_s=np.full(steps, period_s),
        signals=run.book.steps,
        sums=energies[:, :3],
        ports=energies[:, 3:first].reshape(steps, len(users), 4),
        presence=run.book.presence,
        accounts={each.name: energies[:, first + k].copy() for k, each in enumerate(own)},
        changes=np.zeros(steps, dtype=np.int64),
        looked_ns=np.zeros(steps, dtype=np.int64),
    )


@lru_cache(maxsize=8)
def _links(plan: Plan) -> list[Any]:
    """Return what a plan alone says of the links, up and down of each user; arrays are shared by
    all sessions with the plan.
    """
    both = zip(plan.up, plan.down, strict=True)
    return [link.traces(plan.looks_ns[way]) for pair in both for way, link in enumerate(pair)]


def _packets(planned: PacketTraces, rows: Array) -> PacketTraces:
    """Return packets of a plan with what a session put into them."""
    found, dof = rows[planned.seq - 1], (rows.shape[1] - OF_PACKET) // 3
    return replace(
        planned,
        sent_ns=found[:, 3 * dof + 2].astype(np.int64),
        period_s=found[:, 3 * dof + 1].copy(),
        wave=found[:, :dof].copy(),
        integral=found[:, dof : 2 * dof].copy(),
        energy=found[:, 3 * dof].copy(),
        position=found[:, 2 * dof : 3 * dof].copy(),
    )
