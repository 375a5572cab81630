# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The signals of a session as tables: one row per tick, block, step or packet.

A table holds what is sampled together. Columns are named as in the traces
(:mod:`pmwvc_core.traces`); a vector is an array ``(row, dof)``.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmwvc_core.traces import ServerTraces, SessionTraces, UserTraces


class Column(NamedTuple):
    """The unit and the meaning of a column."""

    unit: str
    meaning: str


_TIME = Column("s", "time since the start of the session")
_LOOKED = Column(
    "ns", "from the deadline to the look at the packets that had come; NaN where it is not known"
)
TICKS: Mapping[str, Column] = {
    "time_s": _TIME,
    "tick": Column("", "number of the tick of the force loop"),
    "x_m": Column("m", "position of the device"),
    "xd_m": Column("m/s", "velocity of the device"),
    "f_h": Column("N", "force of the hand on the device; NaN where it is not known"),
    "f_m": Column("N", "force asked for by the controller"),
    "f_applied": Column("N", "force on the device, after the safety limits"),
    "u_m": Column("sqrt(W)", "wave out of the master before its filter"),
    "u_m_lp": Column("sqrt(W)", "wave out of the master after its filter"),
    "v_m": Column("sqrt(W)", "wave into the master after the hold"),
    "lateness_s": Column("s", "wake-up behind its deadline"),
    "compute_s": Column("s", "time the tick took"),
    "looked_ns": _LOOKED,
}
BLOCKS: Mapping[str, Column] = {
    "time_s": Column("s", "end of the block"),
    "state": Column("", "0 starting, 1 coupled, 2 damping, 3 fault"),
}
STEPS: Mapping[str, Column] = {
    "time_s": _TIME,
    "step": Column("", "number of the step of the server"),
    "periods_s": Column("s", "how long the step lasts"),
    "x_o": Column("m", "position of the object"),
    "xd_o": Column("m/s", "velocity of the object"),
    "target": Column("m", "where the task wants the object"),
    "kinetic": Column("J", "kinetic energy of the object"),
    "potential": Column("J", "energy stored in the springs of the contacts"),
    "dissipated": Column("J", "heat of object and contacts so far"),
    "looked_ns": _LOOKED,
}
AVATARS: Mapping[str, Column] = {
    "x_s": Column("m", "position of the avatar"),
    "xd_s": Column("m/s", "velocity of the avatar"),
    "f_s": Column("N", "contact force on the avatar"),
    "u_s": Column("sqrt(W)", "wave received by the server"),
    "v_s": Column("sqrt(W)", "wave sent by the server"),
    "contact": Column("", "1 in contact with the object"),
    "state": Column("", "0 absent, 1 joining, 2 coupled, 3 damping"),
    "energy_u_s": Column("J", "energy of the waves received so far"),
    "energy_v_s": Column("J", "energy of the waves sent so far"),
}
PACKETS: Mapping[str, Column] = {
    "time_s": Column("s", "when the packet was recorded"),
    "epoch": Column("", "which start of the sender sent it"),
    "seq": Column("", "number of the packet"),
    "sent_ns": Column("ns", "time of sending on the sender's monotonic clock"),
    "wave": Column("sqrt(W)", "the wave in the packet"),
    "integral": Column("sqrt(W) s", "running integral of the wave"),
    "energy": Column("J", "energy sent so far"),
    "position": Column("m", "position of the sending end; an avatar's in the frame of its device"),
}
FATES: Mapping[str, Column] = {
    "number": Column("", "number of the packet on the link"),
    "epoch": Column("", "which start of the sender sent it"),
    "seq": Column("", "number given by the sender"),
    "size_bytes": Column("bytes", "size of the packet"),
    "time_in_ns": Column("ns", "when it came in, on the emulator's monotonic clock"),
    "time_due_ns": Column("ns", "when it was due to go out"),
    "time_out_ns": Column("ns", "when it went out; 0: never"),
    "fate": Column(
        "", "0 delivered, 1 lost, 2 duplicate, 3 dropped by the rate, 4 queue full, 5 invalid"
    ),
    "cause": Column("", "0 none, else what decided the fate (PacketFate in docs/messages.md)"),
}


@dataclass(frozen=True)
class Table:
    """Columns that have the same rows, and what they mean."""

    name: str
    columns: Mapping[str, NDArray[Any]]  # (row,) or (row, dof)
    meanings: Mapping[str, Column]


def tables(traces: SessionTraces) -> list[Table]:
    """Return every signal of a session, users first; names are plain words."""
    found: list[Table] = []
    for user in traces.users:
        found += _of_user(user)
    if traces.server is not None:
        found += _of_server(traces.server)
    for packets in traces.packets.values():
        found.append(_table(f"packets_{packets.topic.strip('/')}", packets, PACKETS))
    found += [_table(f"fates_{fates.link}", fates, FATES) for fates in traces.fates.values()]
    return found


def _of_user(user: UserTraces) -> Iterator[Table]:
    yield _table(user.name, user, TICKS)
    energies = {f"energy_{name}": values for name, values in user.energy.items()}
    accounts = {f"account_{name}": values for name, values in user.accounts.items()}
    meanings = {
        **BLOCKS,
        **{name: Column("J", "energy so far, summed by the master") for name in energies},
        **{name: Column("J", "energy kept by the controller") for name in accounts},
    }
    columns = {"time_s": user.block_time_s, "state": user.state, **energies, **accounts}
    yield Table(plain(f"{user.name}_blocks"), columns, meanings)


def _of_server(server: ServerTraces) -> Iterator[Table]:
    steps = _table("server", server, STEPS)
    accounts = {f"account_{name}": values for name, values in server.accounts.items()}
    meanings = {name: Column("J", "energy kept by the server") for name in accounts}
    yield Table("server", {**steps.columns, **accounts}, {**STEPS, **meanings})
    for index, user in enumerate(server.users):
        columns = {name: np.asarray(getattr(server, name)[index]) for name in AVATARS}
        columns["contact"] = columns["contact"].astype(np.uint8)
        columns = {"time_s": server.time_s, **columns}
        yield Table(plain(f"server_{user}"), columns, {"time_s": _TIME, **AVATARS})


def _table(name: str, traces: object, columns: Mapping[str, Column]) -> Table:
    values = {column: np.asarray(getattr(traces, column)) for column in columns}
    if "looked_ns" in values and not len(values["looked_ns"]):
        values["looked_ns"] = np.full(len(values["time_s"]), np.nan)
    return Table(plain(name), values, columns)


def plain(name: str) -> str:
    """Return a name that every tool accepts: letters, digits and underscores."""
    return re.sub(r"\W", "_", name)


def by_axis(name: str, values: NDArray[Any]) -> Sequence[tuple[str, NDArray[Any]]]:
    """Return the axes of a column by name: ``x_m`` of one axis, else ``x_m_1``, ``x_m_2``, ..."""
    if values.ndim == 1 or values.shape[1] == 1:
        return [(name, values.reshape(-1))]
    return [(f"{name}_{number}", axis) for number, axis in enumerate(values.T, start=1)]
