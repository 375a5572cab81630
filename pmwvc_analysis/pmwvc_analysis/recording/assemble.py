# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""From decoded messages to the arrays of :mod:`pmwvc_core.traces`.

A publisher that was started again begins new running sums; they are continued here, so that
energies are sums over the session. Rows are in the order of time.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmwvc_analysis.recording.clocks import clock
from pmwvc_core.numeric import Array
from pmwvc_core.runtime.messages import nanoseconds
from pmwvc_core.traces import FateTraces, PacketTraces, ServerTraces, UserTraces

Integers = NDArray[np.int64]
Messages = Sequence[Any]
ENERGIES = ("u_m", "u_tx", "v_rx", "v_m", "device", "hand")
_PER_TICK = {"x_m": "x", "xd_m": "xd", "f_m": "f_m", "f_applied": "f_applied"} | {
    name: name for name in ("u_m", "u_m_lp", "v_m")
}


def continued(values: Array, epochs: NDArray[np.uint64]) -> Array:
    """Return running sums that go on where a new epoch starts again at zero."""
    result = values.copy()
    for row in np.flatnonzero(epochs[1:] != epochs[:-1]) + 1:
        result[row:] += result[row - 1] - (result[row] - values[row])
    return result


def user_traces(name: str, messages: Messages, starts: Integers, *, zero_ns: int) -> UserTraces:
    """Return the force loop of one user from its MasterTrace blocks and their times [ns]."""
    order = np.argsort(starts, kind="stable")
    blocks = [messages[i] for i in order]
    starts = starts[order]
    sizes = [len(block.lateness) for block in blocks]
    period = float(blocks[0].period)
    within = np.concatenate([np.arange(size) for size in sizes])

    def rows(field: str) -> Array:
        parts = [np.asarray(getattr(b, field), dtype=float).reshape(-1, b.dof) for b in blocks]
        return np.concatenate(parts)

    hand = [
        np.asarray(b.f_h, dtype=float).reshape(-1, b.dof)
        if b.hand_force_known and len(b.f_h) == size * b.dof
        else np.full((size, b.dof), np.nan)
        for b, size in zip(blocks, sizes, strict=True)
    ]
    epochs = np.array([block.epoch for block in blocks], dtype=np.uint64)
    signals: dict[str, Any] = {trace: rows(field) for trace, field in _PER_TICK.items()}
    return UserTraces(
        name=name,
        tick_s=period,
        time_s=np.repeat(clock.seconds(starts, zero_ns), sizes) + within * period,
        tick=np.repeat([int(block.first_tick) for block in blocks], sizes) + within,
        f_h=np.concatenate(hand),
        lateness_s=np.concatenate([np.asarray(b.lateness, dtype=float) for b in blocks]),
        compute_s=np.concatenate([np.asarray(b.compute, dtype=float) for b in blocks]),
        block_time_s=clock.seconds(starts, zero_ns) + np.array(sizes) * period,
        state=np.array([block.state for block in blocks], dtype=np.int64),
        reason=[str(block.reason) for block in blocks],
        energy={
            energy: continued(np.array([getattr(b, f"energy_{energy}") for b in blocks]), epochs)
            for energy in ENERGIES
        },
        accounts=_accounts(blocks),
        block_number=np.array([block.seq for block in blocks], dtype=np.int64),
        missed=_total(blocks, "missed"),
        safety_events=_total(blocks, "safety_events"),
        epoch=epochs,
        **signals,
    )


def _accounts(messages: Messages) -> dict[str, Array]:
    """Return the controller's own energies by name. A message without one, as before a part was
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


def _total(blocks: Messages, field: str) -> int:
    """Return a running count summed over epochs."""
    last: dict[int, int] = {}
    for block in blocks:
        last[block.epoch] = max(last.get(block.epoch, 0), int(getattr(block, field)))
    return sum(last.values())


def server_traces(
    messages: Messages, starts: Integers, *, zero_ns: int
) -> tuple[ServerTraces, Array]:
    """Return the environment from its ServerTrace messages and their times [ns], and how late each
    step was [s].

    Users are those of the last message, in its order; where an earlier one lacks a user, its
    values are NaN.
    """
    order = np.argsort(starts, kind="stable")
    steps = [messages[i] for i in order]
    names = [str(name) for name in steps[-1].users]
    epochs = np.array([step.epoch for step in steps], dtype=np.uint64)
    columns = [{str(name): place for place, name in enumerate(step.users)} for step in steps]

    def of_object(field: str) -> Array:
        return np.array([np.asarray(getattr(step, field), dtype=float) for step in steps])

    def of_user(field: str, name: str, missing: float) -> Array:
        width = steps[-1].dof if field in ("x_s", "xd_s", "f_s", "u_s", "v_s") else 1
        result = np.full((len(steps), width), missing)
        for row, step, column in zip(result, steps, columns, strict=True):
            if (place := column.get(name)) is not None:
                row[:] = getattr(step, field)[place * width : (place + 1) * width]
        return result

    def each(field: str, missing: float = np.nan) -> list[Array]:
        return [of_user(field, name, missing) for name in names]

    def sums(field: str) -> list[Array]:
        return [continued(np.nan_to_num(array[:, 0]), epochs) for array in each(field)]

    traces = ServerTraces(
        users=names,
        period_s=float(steps[-1].period),
        time_s=clock.seconds(starts[order], zero_ns),
        step=np.array([step.step for step in steps], dtype=np.int64),
        x_o=of_object("x_o"),
        xd_o=of_object("xd_o"),
        target=of_object("target"),
        x_s=each("x_s"),
        xd_s=each("xd_s"),
        f_s=each("f_s"),
        u_s=each("u_s"),
        v_s=each("v_s"),
        contact=[array[:, 0] > 0.0 for array in each("contact", 0.0)],
        state=[array[:, 0].astype(np.int64) for array in each("state", 0.0)],
        energy_u_s=sums("energy_u_s"),
        energy_v_s=sums("energy_v_s"),
        kinetic=np.array([step.kinetic for step in steps], dtype=float),
        potential=np.array([step.potential for step in steps], dtype=float),
        dissipated=continued(np.array([step.dissipated for step in steps], dtype=float), epochs),
        accounts=_accounts(steps),
    )
    return traces, np.array([step.lateness for step in steps], dtype=float)


def packet_traces(
    topic: str, messages: Messages, log_ns: Sequence[int], *, zero_ns: int
) -> PacketTraces:
    """Return the packets seen on one topic; those of another length than most are left out."""
    lengths = [len(message.wave) for message in messages]
    dof = max(set(lengths), key=lengths.count)
    rows = [i for i, m in enumerate(messages) if len(m.wave) == dof and len(m.integral) == dof]
    kept = [messages[i] for i in rows]

    def axes(field: str) -> Array:
        return np.array([getattr(message, field) for message in kept], dtype=float).reshape(
            -1, dof
        )

    return PacketTraces(
        topic=topic,
        time_s=clock.seconds(np.array([log_ns[i] for i in rows], dtype=np.int64), zero_ns),
        epoch=np.array([message.epoch for message in kept], dtype=np.uint64),
        seq=np.array([message.seq for message in kept], dtype=np.int64),
        sent_ns=np.array([message.sent_ns for message in kept], dtype=np.int64),
        wave=axes("wave"),
        integral=axes("integral"),
        energy=np.array([message.energy for message in kept], dtype=float),
    )


def fate_traces(link: str, messages: Messages) -> FateTraces:
    """Return what a link did to each packet, blocks put in order and repeated ones left out."""
    blocks = list({int(m.first): m for m in sorted(messages, key=lambda m: int(m.first))}.values())

    def column(field: str) -> Integers:
        return np.concatenate([np.asarray(getattr(b, field)).astype(np.int64) for b in blocks])

    numbers = [np.arange(len(b.seq), dtype=np.int64) + int(b.first) for b in blocks]
    return FateTraces(
        link=link,
        number=np.concatenate(numbers),
        epoch=np.concatenate([np.asarray(b.epoch, dtype=np.uint64) for b in blocks]),
        seq=column("seq"),
        size_bytes=column("bytes"),
        time_in_ns=column("time_in_ns"),
        time_due_ns=column("time_due_ns"),
        time_out_ns=column("time_out_ns"),
        fate=column("fate"),
        cause=column("cause"),
    )


_LINK_NUMBERS = (
    "in_count out_count lost duplicated reordered queued dropped delay_mean delay_min delay_max "
    "delay_error_max rate_hz delay_s jitter_s loss duplicate rate_limit_bps"
).split()


def link_states(messages: Messages, *, zero_ns: int) -> dict[str, Array]:
    """Return counts, delays and settings of a link over time, by the names of LinkState."""
    stamps = np.array([nanoseconds(message.stamp) for message in messages], dtype=np.int64)
    order = np.argsort(stamps, kind="stable")
    columns = {
        name: np.array([getattr(messages[i], name) for i in order], dtype=float)
        for name in _LINK_NUMBERS
    }
    return {"time_s": clock.seconds(stamps[order], zero_ns)} | columns
