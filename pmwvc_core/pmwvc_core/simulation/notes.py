# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What a session in virtual time leaves behind: rows noted while it runs, and their traces."""

from array import array
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pmwvc_core.frame.rows import SIGNALS, Frame, FrameReport, PortRow, ServerRow
from pmwvc_core.numeric import Array, Value
from pmwvc_core.traces import ENERGIES, OF_AVATARS, ServerTraces, UserTraces

OF_OBJECT, STORED = ("x_o", "xd_o", "target"), ("kinetic", "potential", "dissipated")
OF_PORT = PortRow._fields[len(OF_AVATARS) :]


class Numbers:
    """Rows of numbers, noted one after the other; of several axes each is an array."""

    def __init__(self, axes: int = 1) -> None:
        self._axes, self._noted = axes, array("d")

    def write(self, values: Sequence[Any]) -> None:
        """Note the values of one row or several."""
        if self._axes > 1:
            every = np.array([np.broadcast_to(value, self._axes) for value in values])
            self._noted.frombytes(every.tobytes())
        else:
            self._noted.extend(values)

    def columns(self, width: int) -> list[Array]:
        """Return each column of what was noted, ``(rows, axes)``."""
        noted = np.array(self._noted).reshape(-1, width, self._axes)
        return [noted[:, k].copy() for k in range(width)]


class Accounts:
    """Energies noted row by row, under names that are known only once they come."""

    def __init__(self) -> None:
        self._by_names: dict[tuple[str, ...], tuple[list[int], Numbers]] = {}

    def write(self, row: int, energies: Mapping[str, Value]) -> None:
        """Note a row of energies [J]."""
        if energies:
            rows, numbers = self._by_names.setdefault(tuple(energies), ([], Numbers()))
            rows.append(row)
            numbers.write(list(energies.values()))

    def of(self, rows: int) -> dict[str, Array]:
        """Return the rows of each, ``(rows,)``; zero where it was not noted."""
        found: dict[str, Array] = {}
        for names, (noted, numbers) in self._by_names.items():
            for name, values in zip(names, numbers.columns(len(names)), strict=True):
                found.setdefault(name, np.zeros(rows))[noted] = values[:, 0]
        return found


class UserNotes:
    """Notes of one user: a row per tick, and one per frame after its last tick."""

    def __init__(self, dof: int) -> None:
        self.ticks: list[int] = []  # that ran, and when [ns]
        self.times_ns: list[int] = []
        self._signals, self._energies, self._accounts = Numbers(dof), Numbers(), Accounts()
        self._ends: list[int] = []  # of frames [ticks]
        self._states: list[int] = []
        self._reasons: list[str] = []
        self._changes: list[int] = []

    def write_ticks(self, frame: Frame) -> None:
        """Note the signals of consecutive ticks."""
        self._signals.write(frame.values)
        self.ticks += frame.ticks
        self.times_ns += frame.times_ns

    def write_block(
        self, ends: int, report: FrameReport, work: tuple[Value, Value], *, changes: int
    ) -> None:
        """Note the report of a frame that ends before a tick, with the work at the device [J] and
        how many frames have taken changes over.
        """
        self._accounts.write(len(self._ends), report.accounts)
        self._energies.write((report.u_m, report.u_tx, report.v_rx, report.v_m, *work))
        self._ends.append(ends)
        self._states.append(report.state)
        self._reasons.append(report.reason)
        self._changes.append(changes)

    def traces(
        self, name: str, *, ticks: int, first: int, tick_s: float, events: int
    ) -> UserTraces:
        """Return the traces of the ticks that ran, numbered from the first, in a session of so
        many.
        """
        ran = np.array(self.ticks, dtype=np.int64)
        late_ns = np.array(self.times_ns, dtype=np.int64) - ran * round(tick_s * 1e9)
        sums = [column[:, 0] for column in self._energies.columns(len(ENERGIES))]
        signals: dict[str, Any] = dict(
            zip(SIGNALS, self._signals.columns(len(SIGNALS)), strict=True)
        )
        return UserTraces(
            name=name,
            tick_s=tick_s,
            time_s=ran.astype(np.float64) * tick_s,
            tick=ran - first,
            lateness_s=late_ns.astype(np.float64) * 1e-9,
            compute_s=np.zeros(len(ran)),
            block_time_s=np.minimum(np.array(self._ends, dtype=np.float64), ticks) * tick_s,
            state=np.array(self._states, dtype=np.int64),
            reason=self._reasons,
            energy=dict(zip(ENERGIES, sums, strict=True)),
            accounts=self._accounts.of(len(self._ends)),
            changes=np.array(self._changes, dtype=np.int64),
            looked_ns=late_ns,
            missed=int(ran[-1]) - int(ran[0]) + 1 - len(ran) if len(ran) else 0,
            safety_events=events,
            **signals,
        )


class ServerNotes:
    """Notes of the server, a row per step.

    Attributes
    ----------
    ticks, ran_ns, periods_s
        Of each step: its tick, when it ran [ns], how long it lasted [s].
    """

    def __init__(self, dof: int) -> None:
        self.ticks: list[int] = []
        self.ran_ns: list[int] = []
        self.periods_s: list[float] = []
        self._changes: list[int] = []
        self._presence: list[tuple[int, ...]] = []
        self._signals, self._energies, self._accounts = Numbers(dof), Numbers(), Accounts()

    def write(
        self, tick: int, ran_ns: int, period_s: float, row: ServerRow, *, changes: int
    ) -> None:
        """Note one step of the server, with how many have taken changes over."""
        self._accounts.write(len(self.ticks), row.accounts)
        self.ticks.append(tick)
        self.ran_ns.append(ran_ns)
        self.periods_s.append(period_s)
        self._changes.append(changes)
        self._presence.append(row.state)
        self._signals.write([getattr(row, name) for name in OF_OBJECT])
        self._energies.write([getattr(row, name) for name in STORED])
        for port in row.ports:
            self._signals.write(port[: len(OF_AVATARS)])
            self._energies.write(port[len(OF_AVATARS) :])

    def traces(self, users: list[str], *, time_s: Array, tick_ns: int) -> ServerTraces:
        """Return the traces, given when steps began [s]."""
        steps, numbers = len(self.ticks), range(len(users))

        def named(noted: Numbers, common: Sequence[str], each: Sequence[str]) -> dict[str, Any]:
            """Return columns of all by name, and lists of those of each user."""
            first, width = len(common), len(each)
            columns = noted.columns(first + width * len(users))
            found: dict[str, Any] = dict(zip(common, columns, strict=False))
            for k, name in enumerate(each):
                found[name] = [columns[first + width * i + k] for i in numbers]
            return found

        sums = named(self._energies, STORED, OF_PORT)
        return ServerTraces(
            users=users,
            periods_s=np.array(self.periods_s, dtype=np.float64),
            time_s=time_s,
            step=np.arange(1, steps + 1, dtype=np.int64),
            contact=[column[:, 0] != 0.0 for column in sums["contact"]],
            state=list(np.array(self._presence, dtype=np.int64).reshape(-1, len(users)).T.copy()),
            energy_u_s=[column[:, 0] for column in sums["energy_u_s"]],
            energy_v_s=[column[:, 0] for column in sums["energy_v_s"]],
            accounts=self._accounts.of(steps),
            changes=np.array(self._changes, dtype=np.int64),
            looked_ns=np.array(self.ran_ns, dtype=np.int64) - np.array(self.ticks) * tick_ns,
            **{name: sums[name][:, 0] for name in STORED},
            **named(self._signals, OF_OBJECT, OF_AVATARS),
        )
