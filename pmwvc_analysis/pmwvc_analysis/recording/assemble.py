# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The arrays of :mod:`pmwvc_core.traces`, made from decoded messages and their times [ns].

A publisher that was started again begins new running sums; they are continued here, so that
energies are sums over the session. Rows are in the order of time.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmwvc_analysis.recording import clocks
from pmwvc_analysis.recording.own import Decoded
from pmwvc_core.account import continued
from pmwvc_core.frame import SIGNALS
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
    contact_rows,
)

TRACES = dict(zip(PER_AXIS, SIGNALS, strict=True))  # signal of the traces by field


def column(messages: Sequence[object], field: str, kind: type = float) -> NDArray[Any]:
    """Return one value a message."""
    return np.array([getattr(message, field) for message in messages], dtype=kind)


def _joined(messages: Sequence[object], field: str, kind: type = np.int64) -> NDArray[Any]:
    """Return the values of a field one behind the other."""
    parts = (np.atleast_1d(getattr(message, field)) for message in messages)
    return np.concatenate([np.zeros(0, dtype=kind), *parts], dtype=kind)


def _restarts(messages: Sequence[Trace]) -> Integers:
    """Return the rows with which a new epoch begins."""
    epochs = column(messages, "epoch", np.uint64)
    return np.flatnonzero(epochs[1:] != epochs[:-1]) + 1


def user_traces(
    name: str, messages: Sequence[MasterTrace], starts: Integers, *, zero_ns: int
) -> tuple[UserTraces, TakenTraces]:
    """Return the force loop of one user from its MasterTrace blocks, and which packets it was
    given.
    """
    order = np.argsort(starts, kind="stable")
    blocks = [messages[i] for i in order]
    block_s = clocks.seconds(starts[order], zero_ns)
    sizes = np.array([len(block.lateness) for block in blocks])
    first = np.cumsum(sizes) - sizes
    period, dof = float(blocks[0].period), int(blocks[0].dof)
    within = np.arange(sizes.sum()) - np.repeat(first, sizes)
    restarts = _restarts(blocks)
    for block, size in zip(blocks, sizes.tolist(), strict=True):
        if not block.hand_force_known or len(block.f_h) != size * dof:
            block.f_h = [np.nan] * (size * dof)
    traces = UserTraces(
        name=name,
        tick_s=period,
        time_s=np.repeat(block_s, sizes) + within * period,
        tick=np.repeat(column(blocks, "first_tick", np.int64), sizes) + within,
        lateness_s=_joined(blocks, "lateness", float),
        compute_s=_joined(blocks, "compute", float),
        block_time_s=block_s + sizes * period,
        state=column(blocks, "state", np.int64),
        reason=[str(block.reason) for block in blocks],
        energy={n: continued(column(blocks, f"energy_{n}"), restarts) for n in ENERGIES},
        accounts=_accounts(blocks), block_number=column(blocks, "seq", np.int64),
        missed=int(continued(column(blocks, "missed"), restarts)[-1]),
        safety_events=int(continued(column(blocks, "safety_events"), restarts)[-1]),
        epoch=column(blocks, "epoch", np.uint64),
        changes=_joined(blocks, "changes"), looked_ns=_joined(blocks, "looked"),
        orientation=_orientations(blocks),
        grid=round(int(blocks[0].start_ns) / (period * 1e9)) - int(blocks[0].first_tick),
        **{
            trace: _joined(blocks, field, float).reshape(-1, dof)
            for field, trace in TRACES.items()
        },
    )  # fmt: skip
    rows = np.repeat(first, [len(block.taken_seq) for block in blocks])
    rows += _joined(blocks, "taken_tick")
    return traces, TakenTraces(rows, _joined(blocks, "taken_seq"), _joined(blocks, "taken_epoch"))


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


def _orientations(messages: Sequence[object]) -> Array:
    """Return one a message; none where one does not say it, as in recordings of before."""
    found = [getattr(message, "orientation", ()) for message in messages]
    width = min(map(len, found), default=0)
    return np.array([row[:width] for row in found], dtype=float).reshape(len(found), width)


def server_traces(
    messages: Sequence[ServerTrace], starts: Integers, *, zero_ns: int
) -> tuple[ServerTraces, Array, dict[str, TakenTraces]]:
    """Return the environment from its ServerTrace messages, how late each step was [s], and which
    packets of each user it was given.

    Users are those of the last message, in its order; where an earlier one lacks a user, its
    values are NaN.
    """
    order = np.argsort(starts, kind="stable")
    steps = [messages[i] for i in order]
    names, restarts = [str(name) for name in steps[-1].users], _restarts(steps)

    def each(field: str, missing: float = np.nan) -> list[Array]:
        width = steps[-1].dof if field in OF_AVATARS else 1
        found = np.full((len(names), len(steps), width), missing)
        for row, step in enumerate(steps):
            values_of = np.reshape(getattr(step, field), (-1, width))
            for name, values in zip(step.users, values_of, strict=True):
                if name in names:
                    found[names.index(name), row] = values
        return list(found if field in OF_AVATARS else found[..., 0])

    def sums(field: str) -> list[Array]:
        return [continued(np.nan_to_num(array), restarts) for array in each(field)]

    signals: dict[str, Any] = {name: each(name) for name in OF_AVATARS}
    signals |= {name: column(steps, name) for name in (*OF_OBJECT, "kinetic", "potential")}
    traces = ServerTraces(
        users=names, periods_s=column(steps, "period"),
        time_s=clocks.seconds(starts[order], zero_ns), step=column(steps, "step", np.int64),
        contact=[array > 0.0 for array in each("contact", 0.0)],
        state=[array.astype(np.int64) for array in each("state", 0.0)],
        energy_u_s=sums("energy_u_s"), energy_v_s=sums("energy_v_s"),
        dissipated=continued(column(steps, "dissipated"), restarts), accounts=_accounts(steps),
        poses=_poses(steps),
        contacts=contact_rows([getattr(step, "contacts", ()) for step in steps]),
        contained=np.array([getattr(step, "contained", 0) for step in steps], dtype=np.int64),
        changes=_joined(steps, "changes"), looked_ns=_joined(steps, "looked"), **signals,
    )  # fmt: skip
    return traces, column(steps, "lateness"), _taken_by_server(steps, names)


def _poses(steps: Sequence[ServerTrace]) -> dict[str, Array]:
    """Return the poses of the bodies of the last step; recordings of before had none."""
    bodies = list(getattr(steps[-1], "bodies", ()))
    rows = [step.poses for step in steps] if bodies else []
    if not bodies or {len(row) for row in rows} != {7 * len(bodies)}:
        return {}
    return dict(zip(bodies, np.reshape(rows, (len(rows), -1, 7)).swapaxes(0, 1), strict=True))


def _taken_by_server(steps: Sequence[ServerTrace], users: Sequence[str]) -> dict[str, TakenTraces]:
    rows = np.repeat(np.arange(len(steps)), [len(step.taken_seq) for step in steps])
    names = np.array([step.users[user] for step in steps for user in step.taken_user], dtype=str)
    columns = rows, _joined(steps, "taken_seq"), _joined(steps, "taken_epoch")
    return {user: TakenTraces(*(each[names == user] for each in columns)) for user in users}


def packet_traces(topic: str, rows: Sequence[Decoded], *, zero_ns: int) -> PacketTraces:
    """Return the packets seen on one topic; those of another length than most are left out."""
    lengths = [len(row.message.wave) for row in rows]
    dof = max(set(lengths), key=lengths.count)
    fits = np.array([len(row.message.wave) == len(row.message.integral) == dof for row in rows])
    kept = [row.message for row, whole in zip(rows, fits, strict=True) if whole]
    published, recorded = [row.publish_ns for row in rows], [row.log_ns for row in rows]
    arrived_ns = clocks.trusted_times(published, recorded)
    positions = [each.position if len(each.position) == dof else [np.nan] * dof for each in kept]
    return PacketTraces(
        topic=topic, time_s=clocks.seconds(arrived_ns[fits], zero_ns),
        epoch=column(kept, "epoch", np.uint64), seq=column(kept, "seq", np.int64),
        sent_ns=column(kept, "sent_ns", np.int64), period_s=column(kept, "period"),
        wave=column(kept, "wave").reshape(-1, dof), energy=column(kept, "energy"),
        integral=column(kept, "integral").reshape(-1, dof),
        position=np.array(positions, dtype=float).reshape(-1, dof),
        orientation=_orientations(kept),
    )  # fmt: skip
