# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The arrays of :mod:`pmwvc_core.traces`, made from decoded messages.

A publisher that was started again begins new running sums; they are continued here, so that
energies are sums over the session. Rows are in the order of time.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmwvc_analysis.recording import clocks
from pmwvc_analysis.recording.own import Decoded
from pmwvc_core.account import continued
from pmwvc_core.frame.rows import SIGNALS
from pmwvc_core.numeric import Array, Integers
from pmwvc_core.runtime.messages import OF_OBJECT, PER_AXIS
from pmwvc_core.runtime.misfits import MasterTrace, ServerTrace, Trace
from pmwvc_core.traces import (
    ENERGIES,
    OF_AVATARS,
    PacketTraces,
    ServerTraces,
    TakenTraces,
    UserTraces,
)

TRACES = dict(zip(PER_AXIS, SIGNALS, strict=True))  # signal of the traces by field


def _column(messages: Sequence[object], field: str, kind: type = float) -> NDArray[Any]:
    return np.array([getattr(message, field) for message in messages], dtype=kind)


def _joined(messages: Sequence[object], field: str, kind: type = np.int64) -> NDArray[Any]:
    """Return the values of a field one behind the other; empty where it was not recorded."""
    known = messages if all(hasattr(message, field) for message in messages) else ()
    parts: list[NDArray[Any]] = [
        np.atleast_1d(np.asarray(getattr(each, field), dtype=kind)) for each in known
    ]
    return np.concatenate([np.zeros(0, dtype=kind), *parts])


def _restarts(messages: Sequence[Trace]) -> Integers:
    """Return the rows with which a new epoch begins."""
    epochs = _column(messages, "epoch", np.uint64)
    return np.flatnonzero(epochs[1:] != epochs[:-1]) + 1


def user_traces(
    name: str, messages: Sequence[MasterTrace], starts: Integers, *, zero_ns: int
) -> tuple[UserTraces, TakenTraces | None]:
    """Return the force loop of one user from its MasterTrace blocks and their times [ns], and
    which packets it was given (None: not recorded).
    """
    order = np.argsort(starts, kind="stable")
    blocks = [messages[i] for i in order]
    block_s = clocks.seconds(starts[order], zero_ns)
    sizes = [len(block.lateness) for block in blocks]
    first = np.cumsum([0, *sizes[:-1]])
    period, dof = float(blocks[0].period), int(blocks[0].dof)
    within = np.arange(sum(sizes)) - np.repeat(first, sizes)
    hand, restarts = [], _restarts(blocks)
    for block, size in zip(blocks, sizes, strict=True):
        known = block.hand_force_known and len(block.f_h) == size * dof
        force = np.asarray(block.f_h, dtype=float) if known else np.full(size * dof, np.nan)
        hand.append(force.reshape(-1, dof))
    traces = UserTraces(
        name=name,
        tick_s=period,
        time_s=np.repeat(block_s, sizes) + within * period,
        tick=np.repeat(_column(blocks, "first_tick", np.int64), sizes) + within,
        f_h=np.concatenate(hand),
        lateness_s=_joined(blocks, "lateness", float),
        compute_s=_joined(blocks, "compute", float),
        block_time_s=block_s + np.array(sizes) * period,
        state=_column(blocks, "state", np.int64),
        reason=[str(block.reason) for block in blocks],
        energy={n: continued(_column(blocks, f"energy_{n}"), restarts) for n in ENERGIES},
        accounts=_accounts(blocks),
        block_number=_column(blocks, "seq", np.int64),
        missed=_total(blocks, "missed"),
        safety_events=_total(blocks, "safety_events"),
        epoch=_column(blocks, "epoch", np.uint64),
        changes=_joined(blocks, "changes"),
        looked_ns=_joined(blocks, "looked"),
        grid=round(int(blocks[0].start_ns) / (period * 1e9)) - int(blocks[0].first_tick),
        **{
            trace: _joined(blocks, field, float).reshape(-1, dof)
            for field, trace in TRACES.items()
            if field != "f_h"
        },
    )
    if not all(hasattr(block, "taken_seq") for block in blocks):
        return traces, None
    row = np.repeat(first, [len(block.taken_seq) for block in blocks])
    row += _joined(blocks, "taken_tick")
    return traces, TakenTraces(row, _joined(blocks, "taken_seq"), _joined(blocks, "taken_epoch"))


def _accounts(messages: Sequence[Trace]) -> dict[str, Array]:
    """Return the controller's own energies by name. A message without one, as before a block was
    switched on, leaves it as it was: zero, at first.
    """
    names = dict.fromkeys(str(name) for message in messages for name in message.account_names)
    found = {name: np.zeros(len(messages)) for name in names}
    last = dict.fromkeys(names, 0.0)
    for row, message in enumerate(messages):
        last |= zip(message.account_names, message.accounts, strict=True)
        for name, value in last.items():
            found[name][row] = value
    return found


def _total(blocks: Sequence[MasterTrace], field: str) -> int:
    """Return a running count summed over epochs."""
    counts = [(block.epoch, int(getattr(block, field))) for block in blocks]
    return sum(dict(sorted(counts)).values())  # the largest of an epoch stays


def server_traces(
    messages: Sequence[ServerTrace], starts: Integers, *, zero_ns: int
) -> tuple[ServerTraces, Array, dict[str, TakenTraces]]:
    """Return the environment from its ServerTrace messages and their times [ns], how late each
    step was [s], and which packets of each user it was given (empty: not recorded).

    Users are those of the last message, in its order; where an earlier one lacks a user, its
    values are NaN.
    """
    order = np.argsort(starts, kind="stable")
    steps = [messages[i] for i in order]
    names = [str(name) for name in steps[-1].users]
    restarts = _restarts(steps)
    columns = [{str(name): index for index, name in enumerate(step.users)} for step in steps]

    def of_user(field: str, name: str, missing: float) -> Array:
        width = steps[-1].dof if field in OF_AVATARS else 1
        result = np.full((len(steps), width), missing)
        for row, step, column in zip(result, steps, columns, strict=True):
            if (index := column.get(name)) is not None:
                row[:] = getattr(step, field)[index * width : (index + 1) * width]
        return result

    def each(field: str, missing: float = np.nan) -> list[Array]:
        return [of_user(field, name, missing) for name in names]

    def sums(field: str) -> list[Array]:
        return [continued(np.nan_to_num(array[:, 0]), restarts) for array in each(field)]

    signals: dict[str, Any] = {name: each(name) for name in OF_AVATARS}
    signals |= {name: _column(steps, name) for name in (*OF_OBJECT, "kinetic", "potential")}
    traces = ServerTraces(
        users=names,
        periods_s=_column(steps, "period"),
        time_s=clocks.seconds(starts[order], zero_ns),
        step=_column(steps, "step", np.int64),
        contact=[array[:, 0] > 0.0 for array in each("contact", 0.0)],
        state=[array[:, 0].astype(np.int64) for array in each("state", 0.0)],
        energy_u_s=sums("energy_u_s"),
        energy_v_s=sums("energy_v_s"),
        dissipated=continued(_column(steps, "dissipated"), restarts),
        accounts=_accounts(steps),
        changes=_joined(steps, "changes"),
        looked_ns=_joined(steps, "looked"),
        **signals,
    )
    return traces, _column(steps, "lateness"), _taken_by_server(steps, names)


def packet_traces(topic: str, rows: Sequence[Decoded], *, zero_ns: int) -> PacketTraces:
    """Return the packets seen on one topic; those of another length than most are left out."""
    lengths = [len(row.message.wave) for row in rows]
    dof = max(set(lengths), key=lengths.count)
    rows = [row for row in rows if len(row.message.wave) == len(row.message.integral) == dof]
    kept, unknown = [row.message for row in rows], [math.nan] * dof
    positions = [list(m.position) if len(m.position) == dof else unknown for m in kept]
    return PacketTraces(
        topic=topic,
        time_s=clocks.seconds(np.array([row.log_ns for row in rows], dtype=np.int64), zero_ns),
        epoch=_column(kept, "epoch", np.uint64),
        seq=_column(kept, "seq", np.int64),
        sent_ns=_column(kept, "sent_ns", np.int64),
        period_s=_column(kept, "period"),
        wave=_column(kept, "wave").reshape(-1, dof),
        integral=_column(kept, "integral").reshape(-1, dof),
        energy=_column(kept, "energy"),
        position=np.array(positions, dtype=float).reshape(-1, dof),
    )


def _taken_by_server(steps: Sequence[ServerTrace], users: Sequence[str]) -> dict[str, TakenTraces]:
    """Return what the server was given of each user, by its steps in the order of time."""
    if not all(hasattr(step, "taken_seq") for step in steps):
        return {}
    rows = np.repeat(np.arange(len(steps)), [len(step.taken_seq) for step in steps])
    names = np.array([step.users[user] for step in steps for user in step.taken_user], dtype=str)
    columns = rows, _joined(steps, "taken_seq"), _joined(steps, "taken_epoch")
    return {user: TakenTraces(*(each[names == user] for each in columns)) for user in users}
