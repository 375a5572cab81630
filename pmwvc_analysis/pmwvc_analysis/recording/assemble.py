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

from pmwvc_analysis.recording import taken
from pmwvc_analysis.recording.clocks import clock
from pmwvc_analysis.recording.link_blocks import COLUMNS
from pmwvc_core.account import continued
from pmwvc_core.frame.rows import SIGNALS
from pmwvc_core.numeric import Array, Integers
from pmwvc_core.runtime.messages import nanoseconds
from pmwvc_core.runtime.messages.fields import (
    OF_OBJECT,
    PER_AXIS,
    LinkState,
    MasterTrace,
    PacketFate,
    Reception,
    ServerTrace,
    Trace,
    Wave,
)
from pmwvc_core.traces import (
    ENERGIES,
    OF_AVATARS,
    FateTraces,
    PacketTraces,
    ReceptionTraces,
    ServerTraces,
    UserTraces,
)
from pmwvc_core.transport.reception import PASSAGE, REFUSED

TRACES = dict(zip(PER_AXIS, SIGNALS, strict=True))  # signal of the traces by field


def _column(messages: Sequence[object], field: str) -> Array:
    return np.array([getattr(message, field) for message in messages], dtype=float)


def _whole(messages: Sequence[object], field: str) -> Integers:
    return np.array([getattr(message, field) for message in messages], dtype=np.int64)


def _epochs(messages: Sequence[Trace] | Sequence[Wave]) -> NDArray[np.uint64]:
    return np.array([message.epoch for message in messages], dtype=np.uint64)


def _restarts(epochs: NDArray[np.uint64]) -> Integers:
    """Return the rows with which a new epoch begins."""
    return np.flatnonzero(epochs[1:] != epochs[:-1]) + 1


def user_traces(
    name: str, messages: Sequence[MasterTrace], starts: Integers, *, zero_ns: int
) -> UserTraces:
    """Return the force loop of one user from its MasterTrace blocks and their times [ns]."""
    order = np.argsort(starts, kind="stable")
    blocks = [messages[i] for i in order]
    block_s = clock.seconds(starts[order], zero_ns)
    sizes = [len(block.lateness) for block in blocks]
    period = float(blocks[0].period)
    within = np.concatenate([np.arange(size) for size in sizes])

    def ticks(field: str) -> Array:
        return np.concatenate([np.asarray(getattr(b, field), dtype=float) for b in blocks])

    def axes(field: str) -> Array:
        parts = [np.asarray(getattr(b, field), dtype=float).reshape(-1, b.dof) for b in blocks]
        return np.concatenate(parts)

    hand = [
        np.asarray(b.f_h, dtype=float).reshape(-1, b.dof)
        if b.hand_force_known and len(b.f_h) == size * b.dof
        else np.full((size, b.dof), np.nan)
        for b, size in zip(blocks, sizes, strict=True)
    ]
    epochs = _epochs(blocks)
    restarts = _restarts(epochs)
    return UserTraces(
        name=name,
        tick_s=period,
        time_s=np.repeat(block_s, sizes) + within * period,
        tick=np.repeat(_whole(blocks, "first_tick"), sizes) + within,
        f_h=np.concatenate(hand),
        lateness_s=ticks("lateness"),
        compute_s=ticks("compute"),
        block_time_s=block_s + np.array(sizes) * period,
        state=_whole(blocks, "state"),
        reason=[str(block.reason) for block in blocks],
        energy={n: continued(_column(blocks, f"energy_{n}"), restarts) for n in ENERGIES},
        accounts=_accounts(blocks),
        block_number=_whole(blocks, "seq"),
        missed=_total(blocks, "missed"),
        safety_events=_total(blocks, "safety_events"),
        epoch=epochs,
        changes=taken.changes(blocks),
        looked_ns=taken.looked_ns(blocks),
        grid=round(int(blocks[0].start_ns) / (period * 1e9)) - int(blocks[0].first_tick),
        **{trace: axes(field) for field, trace in TRACES.items() if field != "f_h"},
    )


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
    last: dict[int, int] = {}
    for block in blocks:
        last[block.epoch] = max(last.get(block.epoch, 0), int(getattr(block, field)))
    return sum(last.values())


def server_traces(
    messages: Sequence[ServerTrace], starts: Integers, *, zero_ns: int
) -> tuple[ServerTraces, Array]:
    """Return the environment from its ServerTrace messages and their times [ns], and how late each
    step was [s].

    Users are those of the last message, in its order; where an earlier one lacks a user, its
    values are NaN.
    """
    order = np.argsort(starts, kind="stable")
    steps = [messages[i] for i in order]
    names = [str(name) for name in steps[-1].users]
    restarts = _restarts(_epochs(steps))
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
        time_s=clock.seconds(starts[order], zero_ns),
        step=_whole(steps, "step"),
        contact=[array[:, 0] > 0.0 for array in each("contact", 0.0)],
        state=[array[:, 0].astype(np.int64) for array in each("state", 0.0)],
        energy_u_s=sums("energy_u_s"),
        energy_v_s=sums("energy_v_s"),
        dissipated=continued(_column(steps, "dissipated"), restarts),
        accounts=_accounts(steps),
        changes=taken.changes(steps),
        looked_ns=taken.looked_ns(steps),
        **signals,
    )
    return traces, _column(steps, "lateness")


def packet_traces(
    topic: str, messages: Sequence[Wave], log_ns: Sequence[int], *, zero_ns: int
) -> PacketTraces:
    """Return the packets seen on one topic; those of another length than most are left out."""
    lengths = [len(message.wave) for message in messages]
    dof = max(set(lengths), key=lengths.count)
    rows = [i for i, m in enumerate(messages) if len(m.wave) == dof and len(m.integral) == dof]
    kept = [messages[i] for i in rows]
    unknown = [math.nan] * dof
    positions = [list(m.position) if len(m.position) == dof else unknown for m in kept]
    return PacketTraces(
        topic=topic,
        time_s=clock.seconds(np.array([log_ns[i] for i in rows], dtype=np.int64), zero_ns),
        epoch=_epochs(kept),
        seq=_whole(kept, "seq"),
        sent_ns=_whole(kept, "sent_ns"),
        period_s=_column(kept, "period"),
        wave=_column(kept, "wave").reshape(-1, dof),
        integral=_column(kept, "integral").reshape(-1, dof),
        energy=_column(kept, "energy"),
        position=np.array(positions, dtype=float).reshape(-1, dof),
    )


def fate_traces(link: str, messages: Sequence[PacketFate]) -> FateTraces:
    """Return the fate of each packet of a link, blocks in order and repeated ones left out."""
    blocks = list({int(m.first): m for m in sorted(messages, key=lambda m: int(m.first))}.values())

    numbers = [np.arange(len(b.seq), dtype=np.int64) + int(b.first) for b in blocks]
    columns = {
        name: np.concatenate([np.asarray(getattr(b, field)).astype(np.int64) for b in blocks])
        for field, name in COLUMNS.items()
    }
    columns["epoch"] = np.concatenate([np.asarray(b.epoch, dtype=np.uint64) for b in blocks])
    return FateTraces(link=link, number=np.concatenate(numbers), **columns)


_RECEIVED = ["accepted", "beginnings", "lost", "duplicate", "reordered", *REFUSED]
_RECEIVED.append("other_controller")
_LINK_NUMBERS = (
    "in_count out_count lost duplicated reordered corrupted queued dropped "
    "delay_mean delay_min delay_max delay_error_max rate_hz delay_s jitter_s loss duplicate "
    "rate_limit_bps"
).split()


def link_states(messages: Sequence[LinkState], *, zero_ns: int) -> dict[str, Array]:
    """Return counts, delays and settings of a link over time, by the names of LinkState."""
    stamps = clock.stamps(messages)
    order = np.argsort(stamps, kind="stable")
    names = [name for name in _LINK_NUMBERS if all(hasattr(each, name) for each in messages)]
    columns = {name: _column(messages, name)[order] for name in names}
    return {"time_s": clock.seconds(stamps[order], zero_ns)} | columns


def reception_traces(link: str, messages: Sequence[Reception]) -> ReceptionTraces:
    """Return the last report of each start of a receiver, added up."""
    last: dict[int, Reception] = {}
    passage = {name: math.nan for name in PASSAGE}
    for message in sorted(messages, key=lambda each: each.seq):
        last[int(message.epoch)] = message
    for message in sorted(messages, key=lambda each: nanoseconds(each.stamp)):
        values = {name: float(getattr(message, name)) for name in PASSAGE}
        if math.isfinite(values["round_trip"]):
            passage = values
    counts = {name: sum(int(getattr(m, name)) for m in last.values()) for name in _RECEIVED}
    return ReceptionTraces(link, receivers=len(last), counts=counts, passage=passage)
