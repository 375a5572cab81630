# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The traces of a session that ran in bulk."""

import numpy as np

from pmwvc_core.frame.rows import SIGNALS
from pmwvc_core.made.accounts import accounts_of_server, accounts_of_user
from pmwvc_core.master.safety.states import state_of, text_of
from pmwvc_core.numeric import Array
from pmwvc_core.plant.task import offset, task_of
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.buffers import add_learned
from pmwvc_core.simulation.bulk.book import OF_PACKET
from pmwvc_core.simulation.bulk.run import Run
from pmwvc_core.simulation.links import SimulatedLink
from pmwvc_core.simulation.network_traces import fate_traces, taken_traces
from pmwvc_core.traces import (
    ENERGIES,
    OF_AVATARS,
    PacketTraces,
    ReceptionTraces,
    ServerTraces,
    SessionTraces,
    UserTraces,
)
from pmwvc_core.transport.reception import counts, passage


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
    for user in users:
        name = scenario.users[user].name
        add_learned(traces, name, run.book.energies[-1, 7 + 4 * user])
        ends = (("up", f"/{name}", f"/server/{name}"), ("down", f"/server/{name}", f"/{name}"))
        for way, (which, sender, receiver) in enumerate(ends):
            link, topic = (plan.up, plan.down)[way][user], f"wave_{which}"
            rows = run.book.packets[2 * user + way]
            known = f"{name}/{which}"
            traces.fates[known] = fate_traces(link, known)
            traces.receptions[known] = ReceptionTraces(
                known,
                receivers=1,
                counts=counts(link.receiver),
                passage=passage(link.receiver.path.estimate()),
            )
            sent = [packet.seq - 1 for packet in link.sent]
            arrived = [packet.seq - 1 for packet, _ in link.arrived]
            sent_ns = [packet.sent_ns for packet in link.sent]
            arrived_ns = [now_ns for _, now_ns in link.arrived]
            for side, these, at_ns in ((sender, sent, sent_ns), (receiver, arrived, arrived_ns)):
                packets = _packets(f"{side}/{topic}", link, rows, these, at_ns)
                traces.packets[packets.topic] = packets
                traces.counts[packets.topic] = {"messages": len(these), "missing": 0}
            traces.taken[known] = taken_traces(link, _looks_ns(scenario, way))
    return traces


def _user(run: Run, number: int) -> UserTraces:
    user, tick_s = run.scenario.users[number], run.scenario.tick_s
    signals, blocks = run.book.signals[number], run.book.blocks[number]
    ticks = signals.shape[1]
    every = np.arange(ticks, dtype=np.int64)
    ends = np.append(np.arange(user.master.rate_drop, ticks, user.master.rate_drop), ticks)
    blocks = blocks[: len(ends)]
    causes = blocks[:, 0].astype(np.int64)
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
        state=np.array([state_of(cause) for cause in causes.tolist()], dtype=np.int64),
        reason=[str(text_of(cause, user.safety)) for cause in causes.tolist()],
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
    first = 4 + 4 * len(users)
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
        target=_target(scenario, book.energies[:, 3]),
        contact=[book.energies[:, 6 + 4 * i] != 0.0 for i in users],
        state=[column.copy() for column in book.presence.T],
        energy_u_s=[book.energies[:, 4 + 4 * i].copy() for i in users],
        energy_v_s=[book.energies[:, 5 + 4 * i].copy() for i in users],
        kinetic=book.energies[:, 0].copy(),
        potential=book.energies[:, 1].copy(),
        dissipated=book.energies[:, 2].copy(),
        accounts=accounts,
        changes=np.zeros(steps, dtype=np.int64),
        looked_ns=np.zeros(steps, dtype=np.int64),
        **each,
    )


def _target(scenario: Scenario, times_s: Array) -> Array:
    """Return where the object is to be brought at times of the task ``(steps, dof)`` [m]."""
    task = task_of(scenario.task, scenario.dof)
    return np.array([offset(time_s, task) for time_s in times_s.tolist()])


def _looks_ns(scenario: Scenario, way: int) -> list[int]:
    """Return when receivers looked [ns]: the server at its steps, a master at its ticks."""
    every = scenario.period_ticks if way == 0 else 1
    tick_ns = round(scenario.tick_s * 1e9)
    ticks = round(scenario.duration_s / scenario.tick_s)
    return list(range(0, ticks * tick_ns, every * tick_ns))


def _packets(
    topic: str, link: SimulatedLink, rows: Array, these: list[int], at_ns: list[int]
) -> PacketTraces:
    found, dof = rows[np.array(these, dtype=np.int64)], (rows.shape[1] - OF_PACKET) // 3
    epoch = link.sent[0].epoch if link.sent else 0
    return PacketTraces(
        topic=topic,
        time_s=np.array(at_ns, dtype=float) * 1e-9,
        epoch=np.full(len(these), epoch, dtype=np.uint64),
        seq=np.array(these, dtype=np.int64) + 1,
        sent_ns=found[:, 3 * dof + 2].astype(np.int64),
        period_s=found[:, 3 * dof + 1].copy(),
        wave=found[:, :dof].copy(),
        integral=found[:, dof : 2 * dof].copy(),
        energy=found[:, 3 * dof].copy(),
        position=found[:, 2 * dof : 3 * dof].copy(),
    )
