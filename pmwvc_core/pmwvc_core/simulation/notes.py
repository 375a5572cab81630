# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What a session in virtual time leaves behind: rows noted while it runs, and the traces of these,
or of the arrays of a session in bulk (:mod:`.bulk.book`).
"""

from array import array
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from pmwvc_core.ends.forms import vector
from pmwvc_core.frame.rows import SIGNALS, Frame, FrameReport, ServerRow
from pmwvc_core.numeric import Array, Integers, Value
from pmwvc_core.traces import ENERGIES, OF_AVATARS, ServerTraces, UserTraces


class Step(NamedTuple):
    """A step of the server: its tick, when it ran [ns], how long it lasted [s], the server after
    it, and how many steps have taken changes over.
    """

    tick: int
    ran_ns: int
    period_s: float
    row: ServerRow
    changes: int


class UserNotes:
    """Notes of one user."""

    def __init__(self, dof: int) -> None:
        self.ticks: list[int] = []  # that ran, and when [ns]
        self.times_ns: list[int] = []
        # That ended: before which tick, report, work at the device [J], and how many frames have
        # taken changes over.
        self.frames: list[tuple[int, FrameReport, tuple[Value, Value], int]] = []
        self._dof, self._signals = dof, array("d")

    def write(self, frame: Frame) -> None:
        """Note the signals of consecutive ticks."""
        if self._dof == 1:
            self._signals.extend(frame.values)  # type: ignore[arg-type]
        else:
            self._signals.frombytes(columns(frame.values, self._dof).tobytes())
        self.ticks += frame.ticks
        self.times_ns += frame.times_ns

    def traces(
        self, name: str, *, ticks: int, first: int, tick_s: float, events: int
    ) -> UserTraces:
        """Return the traces of the ticks that ran, numbered from the first, in a session of so
        many.
        """
        ran = np.array(self.ticks, dtype=np.int64)
        late_ns = np.array(self.times_ns, dtype=np.int64) - ran * round(tick_s * 1e9)
        signals = np.array(self._signals).reshape(-1, len(SIGNALS), self._dof)
        reports = [report for _, report, _, _ in self.frames]
        sums = [each for _, report, work, _ in self.frames for each in (*report[2:6], *work)]
        energies = columns(sums, 1).reshape(-1, len(ENERGIES)).T.copy()
        ends, changes = [each[0] for each in self.frames], [each[3] for each in self.frames]
        named: dict[str, Any] = {name: signals[:, k].copy() for k, name in enumerate(SIGNALS)}
        return UserTraces(
            name=name,
            tick_s=tick_s,
            time_s=ran.astype(np.float64) * tick_s,
            tick=ran - first,
            lateness_s=late_ns.astype(np.float64) * 1e-9,
            compute_s=np.zeros(len(ran)),
            block_time_s=np.minimum(np.array(ends, dtype=np.float64), ticks) * tick_s,
            state=np.array([report.state for report in reports], dtype=np.int64),
            reason=[report.reason for report in reports],
            energy=dict(zip(ENERGIES, energies, strict=True)),
            accounts=accounts_of([report.accounts for report in reports]),
            changes=np.array(changes, dtype=np.int64),
            looked_ns=late_ns,
            missed=int(ran[-1]) - int(ran[0]) + 1 - len(ran) if len(ran) else 0,
            safety_events=events,
            **named,
        )


def columns(values: Iterable[Value], axes: int) -> Array:
    """Return signals ``(rows, axes)``; a number stands for all axes."""
    every = [vector(value, axes) for value in values]
    return np.array(every, dtype=float).reshape(len(every), axes)


def accounts_of(rows: Sequence[Mapping[str, Value]]) -> dict[str, Array]:
    """Return energies by name, ``(rows,)`` [J]; zero in a row without that name."""
    names = dict.fromkeys(name for row in rows for name in row)
    return {name: np.array([float(row.get(name, 0.0)) for row in rows]) for name in names}


def stepped_server(
    users: list[str], steps: Sequence[Step], *, time_s: Array, tick_ns: int, dof: int
) -> ServerTraces:
    """Return the traces of the server's steps, given when they began [s]."""
    rows, of_each = [step.row for step in steps], len(OF_AVATARS)
    signals: list[Value] = []
    for row in rows:
        avatars: list[Any] = [value for port in row.ports for value in port[:of_each]]
        signals += (row.x_o, row.xd_o, *avatars, row.target)
    sums = [(row.kinetic, row.potential, row.dissipated) for row in rows]
    ports = [port[of_each:] for row in rows for port in row.ports]
    late_ns = [step.ran_ns - step.tick * tick_ns for step in steps]
    every = columns(signals, dof).reshape(-1, 3 + of_each * len(users), dof)
    return server_traces(
        users,
        time_s=time_s,
        periods_s=np.array([step.period_s for step in steps], dtype=float),
        signals=every.swapaxes(0, 1).copy(),
        sums=np.array(sums, dtype=float).reshape(-1, 3),
        ports=np.array(ports, dtype=float).reshape(-1, len(users), 3),
        presence=np.array([row.state for row in rows], dtype=np.int64).reshape(-1, len(users)),
        accounts=accounts_of([row.accounts for row in rows]),
        changes=np.array([step.changes for step in steps], dtype=np.int64),
        looked_ns=np.array(late_ns, dtype=np.int64),
    )


def server_traces(
    users: list[str], *, signals: Array, sums: Array, ports: Array, presence: Integers, **rest: Any
) -> ServerTraces:
    """Return the traces of the server.

    ``signals`` are of object, avatars and target, ``(3 + 5 users, steps, axes)``; ``sums`` the
    kinetic, potential and dissipated energy, ``(steps, 3)`` [J]; ``ports`` energies of both waves
    and whether there is contact, ``(steps, users, 3 or more)``; ``presence`` ``(steps, users)``.
    """
    first, of_each = [2 + len(OF_AVATARS) * i for i in range(len(users))], enumerate(OF_AVATARS)
    avatars: dict[str, Any] = {name: [signals[at + k] for at in first] for k, name in of_each}
    u_j, v_j, touches, *_ = np.moveaxis(ports, 2, 0).swapaxes(1, 2)
    kinetic, potential, dissipated = sums.T.copy()
    return ServerTraces(
        users=users,
        step=np.arange(1, len(sums) + 1, dtype=np.int64),
        x_o=signals[0],
        xd_o=signals[1],
        target=signals[-1],
        contact=list(touches != 0.0),
        state=list(presence.T.copy()),
        energy_u_s=list(u_j.copy()),
        energy_v_s=list(v_j.copy()),
        kinetic=kinetic,
        potential=potential,
        dissipated=dissipated,
        **avatars,
        **rest,
    )
