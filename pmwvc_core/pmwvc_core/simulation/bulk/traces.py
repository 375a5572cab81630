# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The traces of a session that ran in bulk."""

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from pmwvc_core.controllers.library import accounts_of_server, accounts_of_user
from pmwvc_core.frame.rows import SIGNALS
from pmwvc_core.master.safety import state_of, text_of
from pmwvc_core.numeric import Array, Integers
from pmwvc_core.simulation.bulk.book import OF_PACKET
from pmwvc_core.simulation.bulk.plan import Plan
from pmwvc_core.simulation.bulk.run import Run
from pmwvc_core.simulation.links import SimulatedLink
from pmwvc_core.traces import (
    ENERGIES,
    OF_AVATARS,
    FateTraces,
    PacketTraces,
    ReceptionTraces,
    ServerTraces,
    SessionTraces,
    TakenTraces,
    UserTraces,
)


def traces_of(run: Run) -> SessionTraces:
    """Return the traces of a session."""
    scenario, plan = run.scenario, run.plan
    users = range(len(scenario.users))
    traces = SessionTraces(
        source="simulated",
        duration_s=run.book.signals.shape[2] * scenario.tick_s,
        users=[_user(run, user) for user in users],
        server=_server(run),
    )
    links = _links(plan)
    for user in users:
        name = scenario.users[user].name
        ends = (("up", f"/{name}", f"/server/{name}"), ("down", f"/server/{name}", f"/{name}"))
        for way, (which, *sides) in enumerate(ends):
            link, known = links[2 * user + way], f"{name}/{which}"
            rows = run.book.packets[2 * user + way]
            traces.fates[known] = replace(link.fates, link=known)
            traces.receptions[known] = replace(link.reception, link=known)
            for side, seen in zip(sides, link.seen, strict=True):
                packets = _packets(f"{side}/wave_{which}", rows, seen, link.epoch)
                traces.packets[packets.topic] = packets
                traces.counts[packets.topic] = {"messages": len(seen[0]), "missing": 0}
            traces.taken[known] = link.taken
    learned = [float(run.book.energies[-1, 6 + 4 * user]) for user in users]
    traces.events += learned_events([user.name for user in scenario.users], learned)
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
    energies = np.concatenate([blocks[:, 4:8], blocks[:, 2:4]], axis=1).T.copy()
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
        energy=dict(zip(ENERGIES, energies, strict=True)),
        accounts={each.name: blocks[:, 8 + k].copy() for k, each in enumerate(own)},
        changes=np.zeros(len(ends), dtype=np.int64),
        looked_ns=np.zeros(ticks, dtype=np.int64),
        safety_events=int(blocks[-1, 1]),
        **dict(zip(SIGNALS, signals, strict=True)),
    )


def _server(run: Run) -> ServerTraces:
    scenario, book = run.scenario, run.book
    steps, users = len(book.energies), range(len(scenario.users))
    each = {name: [book.steps[2 + 5 * i + k] for i in users] for k, name in enumerate(OF_AVATARS)}
    first = 3 + 4 * len(users)
    accounts = {
        entry.name: book.energies[:, first + k].copy()
        for k, entry in enumerate(
            accounts_of_server(scenario.controller, scenario.channel, scenario.server)
        )
    }
    return ServerTraces(
        users=[user.name for user in scenario.users],
        periods_s=np.full(steps, scenario.server.period_s),
        time_s=np.arange(steps, dtype=np.float64) * scenario.server.period_s,
        step=np.arange(1, steps + 1, dtype=np.int64),
        x_o=book.steps[0],
        xd_o=book.steps[1],
        target=book.steps[-1],
        contact=[book.energies[:, 5 + 4 * i] != 0.0 for i in users],
        state=[column.copy() for column in book.presence.T],
        energy_u_s=[book.energies[:, 3 + 4 * i].copy() for i in users],
        energy_v_s=[book.energies[:, 4 + 4 * i].copy() for i in users],
        kinetic=book.energies[:, 0].copy(),
        potential=book.energies[:, 1].copy(),
        dissipated=book.energies[:, 2].copy(),
        accounts=accounts,
        changes=np.zeros(steps, dtype=np.int64),
        looked_ns=np.zeros(steps, dtype=np.int64),
        **each,
    )


class _Link(NamedTuple):
    """What the plan alone says of a link; arrays are shared by all sessions with the plan."""

    fates: FateTraces
    reception: ReceptionTraces
    taken: TakenTraces
    seen: tuple[tuple[Integers, Array], ...]  # rows of packets and times [s]: sent, arrived
    epoch: int


@lru_cache(maxsize=8)
def _links(plan: Plan) -> list[_Link]:
    """Return what a plan says of the links, up and down of each user."""
    both = zip(plan.up, plan.down, strict=True)
    return [_link(link, plan.looks_ns[way]) for pair in both for way, link in enumerate(pair)]


def _link(link: SimulatedLink, looks_ns: range) -> _Link:
    sent = [(packet.seq - 1, packet.sent_ns) for packet in link.sent]
    arrived = [(packet.seq - 1, now_ns) for packet, now_ns in link.arrived]
    seen = [np.array(each, dtype=np.int64).reshape(-1, 2).T for each in (sent, arrived)]
    return _Link(
        link.fate_traces(""),
        link.reception(""),
        link.taken_traces(looks_ns),
        tuple((rows, at_ns.astype(float) * 1e-9) for rows, at_ns in seen),
        link.sent[0].epoch if link.sent else 0,
    )


def _packets(topic: str, rows: Array, seen: tuple[Integers, Array], epoch: int) -> PacketTraces:
    these, time_s = seen
    found, dof = rows[these], (rows.shape[1] - OF_PACKET) // 3
    return PacketTraces(
        topic=topic,
        time_s=time_s,
        epoch=np.full(len(these), epoch, dtype=np.uint64),
        seq=these + 1,
        sent_ns=found[:, 3 * dof + 2].astype(np.int64),
        period_s=found[:, 3 * dof + 1].copy(),
        wave=found[:, :dof].copy(),
        integral=found[:, dof : 2 * dof].copy(),
        energy=found[:, 3 * dof].copy(),
        position=found[:, 2 * dof : 3 * dof].copy(),
    )
